#include "robots/mjcf_mounts.h"

#include <fmt/format.h>

#include <set>
#include <sstream>

#include "core/errors.h"
#include "robots/read_xml.h"

namespace atlas::robots {
namespace {

using boost::property_tree::ptree;

void CollectNames(const ptree& node, std::set<std::string>* names) {
  for (const auto& [tag, child] : node) {
    if (tag == "joint" || tag == "site" || tag == "body" || tag == "geom") {
      names->insert(tag + " " + child.get("<xmlattr>.name", ""));
    }
    CollectNames(child, names);
  }
}

const ptree* FindBody(const ptree& node, const std::string& name) {
  for (const auto& [tag, child] : node) {
    if (tag == "body" && child.get("<xmlattr>.name", "") == name) return &child;
    if (const ptree* found = FindBody(child, name)) return found;
  }
  return nullptr;
}

template <int N>
Eigen::Matrix<double, N, 1> Numbers(const std::string& text, const std::string& what) {
  std::istringstream in(text);
  Eigen::Matrix<double, N, 1> v;
  for (int i = 0; i < N; ++i) {
    if (!(in >> v[i])) throw core::InputError(fmt::format("{}: '{}' is not {} numbers", what, text, N));
  }
  return v;
}

core::Pose SitePose(const ptree& base, const std::string& site, const std::string& file) {
  for (const auto& [tag, child] : base) {
    if (tag != "site" || child.get("<xmlattr>.name", "") != site) continue;
    const std::string what = fmt::format("{}: site '{}'", file, site);
    const auto p = Numbers<3>(child.get("<xmlattr>.pos", "0 0 0"), what + ", pos");
    const auto q = Numbers<4>(child.get("<xmlattr>.quat", "1 0 0 0"), what + ", quat");
    if (q.norm() < 1e-6) throw core::InputError(what + ", quat: its length is 0");
    return core::MakePose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix(), p);
  }
  throw core::InputError(fmt::format("{}: body 'base' has no site '{}'", file, site));
}

}  // namespace

void ReadMounts(RobotSpec* spec) {
  const ptree tree = ReadXml(spec->mjcf);
  const std::string file = spec->mjcf.string();
  const ptree* base = FindBody(tree, "base");
  if (base == nullptr) throw core::InputError(file + ": no body 'base'");

  std::set<std::string> names;
  CollectNames(tree, &names);
  const auto need = [&](const std::string& name) {
    if (!names.contains(name)) throw core::InputError(fmt::format("{}: no {}", file, name));
  };
  for (const std::string leg : {"LF", "RF", "LH", "RH"}) {
    for (const std::string link : {"_HIP", "_THIGH", "_SHANK"}) need("body " + leg + link);
    for (const std::string joint : {"_HAA", "_HFE", "_KFE"}) need("joint " + leg + joint);
    need("site " + leg + "_F");
    need("geom " + leg + "_FOOT");
  }
  spec->T_base_lidar = SitePose(*base, "lidar", file);
  spec->T_base_depth = SitePose(*base, "depth", file);
}

}  // namespace atlas::robots

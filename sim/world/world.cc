#include "sim/world/world.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "core/errors.h"
#include "sim/world/robot_meshes.h"
#include "sim/world/static_geometry.h"
#include "sim/world/world_model.h"

namespace atlas::sim {
namespace {

using core::Mat3;
using core::Vec3;

constexpr const char* kLegNames[kLegs] = {"LF", "RF", "LH", "RH"};
constexpr double kActivationReachM = 1.3;  ///< legs stretched (0.9 m) plus what the base travels in a period
constexpr int kActivationSteps = 50;

enum class Link : uint8_t { kStatic, kBody, kShank, kFoot };

struct DataDeleter {
  void operator()(mjData* d) const { mj_deleteData(d); }
};
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

int Find(const mjModel& m, const robots::RobotSpec& robot, int type, const std::string& name) {
  const int id = mj_name2id(&m, type, name.c_str());
  if (id >= 0) return id;
  throw core::InputError(
      fmt::format("{}: no {} '{}'", robot.mjcf.string(), type == mjOBJ_JOINT ? "joint" : "element", name));
}

}  // namespace

struct World::Impl {
  struct LegIds {
    int site = 0, foot = 0;
    std::array<int, 3> joint{}, dof{}, qpos{}, actuator{};
  };

  Impl(const scenes::SceneSpec& scene, const robots::RobotSpec& robot);
  void FindLegs(const robots::RobotSpec& robot);
  void Classify();
  void ReadState();
  void ReadContacts();

  ModelPtr model;
  DataPtr data;
  std::optional<StaticGeometry> ground;
  int base = 0;
  std::array<LegIds, kLegs> ids;
  std::array<LegGeometry, kLegs> geometry;
  std::vector<Link> link_of_geom;
  std::vector<int> leg_of_foot;  ///< a geom each; -1 where it is no foot
  std::vector<int> bodies;
  std::vector<core::TriMesh> meshes;
  RobotState state;
  LinkContacts contacts;
  int steps_to_activation = 0;
  int64_t steps = 0;  ///< the clock: MuJoCo's own restarts when it resets a state gone bad
};

World::Impl::Impl(const scenes::SceneSpec& scene, const robots::RobotSpec& robot) {
  model = CompileModel(scene, robot);
  data.reset(mj_makeData(model.get()));
  base = Find(*model, robot, mjOBJ_BODY, "base");
  if (model->nv != kDofs || model->nq != kDofs + 1 || model->nu != 12) {
    throw core::InputError(
        fmt::format("{}: {} degrees of freedom and {} motors; a free base with 12 joints and 12 "
                    "motors is needed",
                    robot.mjcf.string(), model->nv, model->nu));
  }
  FindLegs(robot);
  Classify();
  mj_forward(model.get(), data.get());
  ground.emplace(model.get(), data.get());
  for (int b = 1; b < model->nbody; ++b) {
    if (model->body_rootid[b] != base) continue;
    bodies.push_back(b);
    meshes.push_back(BodyMesh(*model, b));
  }
}

void World::Impl::FindLegs(const robots::RobotSpec& robot) {
  for (int i = 0; i < kLegs; ++i) {
    LegIds& leg = ids[i];
    const std::string name = kLegNames[i];
    leg.site = Find(*model, robot, mjOBJ_SITE, name + "_F");
    leg.foot = Find(*model, robot, mjOBJ_GEOM, name + "_FOOT");
    const char* suffix[3] = {"_HAA", "_HFE", "_KFE"};
    for (int k = 0; k < 3; ++k) {
      leg.joint[k] = Find(*model, robot, mjOBJ_JOINT, name + suffix[k]);
      leg.actuator[k] = Find(*model, robot, mjOBJ_ACTUATOR, name + suffix[k]);
      leg.dof[k] = model->jnt_dofadr[leg.joint[k]];
      leg.qpos[k] = model->jnt_qposadr[leg.joint[k]];
    }
    const auto body_position = [&](int joint) {
      return Vec3(Eigen::Map<const Vec3>(model->body_pos + 3 * model->jnt_bodyid[joint]));
    };
    const Vec3 hfe = body_position(leg.joint[1]), kfe = body_position(leg.joint[2]);
    const Vec3 foot = Eigen::Map<const Vec3>(model->site_pos + 3 * leg.site);
    LegGeometry& g = geometry[i];
    g.haa_base = body_position(leg.joint[0]);
    g.hfe_forward_m = hfe.x();
    g.lateral_m = hfe.y() + kfe.y() + foot.y();
    g.thigh_m = -kfe.z();
    g.shank_m = -foot.z();
    g.foot_radius_m = model->geom_size[3 * leg.foot];
    g.fore = g.haa_base.x() > 0.0 ? 1.0 : -1.0;
    g.side = g.haa_base.y() > 0.0 ? 1.0 : -1.0;
    if (g.thigh_m <= 0.0 || g.shank_m <= 0.0) {
      throw core::InputError(fmt::format("{}: leg {}: thigh and shank must point down at zero angles",
                                         robot.mjcf.string(), name));
    }
  }
}

void World::Impl::Classify() {
  link_of_geom.assign(static_cast<size_t>(model->ngeom), Link::kStatic);
  leg_of_foot.assign(static_cast<size_t>(model->ngeom), -1);
  for (int g = 0; g < model->ngeom; ++g) {
    if (model->body_rootid[model->geom_bodyid[g]] == base) link_of_geom[static_cast<size_t>(g)] = Link::kBody;
  }
  for (int i = 0; i < kLegs; ++i) {
    const int shank = model->site_bodyid[ids[i].site];
    for (int k = 0; k < model->body_geomnum[shank]; ++k) {
      link_of_geom[static_cast<size_t>(model->body_geomadr[shank] + k)] = Link::kShank;
    }
    link_of_geom[static_cast<size_t>(ids[i].foot)] = Link::kFoot;
    leg_of_foot[static_cast<size_t>(ids[i].foot)] = i;
  }
}

void World::Impl::ReadState() {
  const mjData& d = *data;
  state.time_s = static_cast<double>(steps) * kStepS;
  state.p_base = Eigen::Map<const Vec3>(d.qpos);
  state.R_base =
      Eigen::Quaterniond(d.qpos[3], d.qpos[4], d.qpos[5], d.qpos[6]).normalized().toRotationMatrix();
  state.qvel.head<6>() = Eigen::Map<const Vec6>(d.qvel);
  state.v_base = state.qvel.head<3>();
  state.w_base_local = state.qvel.segment<3>(3);
  state.p_com = Eigen::Map<const Vec3>(d.subtree_com + 3 * base);
  for (int i = 0; i < kLegs; ++i) {
    LegState& leg = state.leg[i];
    leg.p_foot = Eigen::Map<const Vec3>(d.site_xpos + 3 * ids[i].site);
    const Vec3 r = leg.p_foot - state.p_base;
    leg.J_base.leftCols<3>().setIdentity();
    for (int k = 0; k < 3; ++k) {
      leg.J_base.col(3 + k) = Vec3(state.R_base.col(k)).cross(r);
      const int joint = ids[i].joint[k];
      const Vec3 axis = Eigen::Map<const Vec3>(d.xaxis + 3 * joint);
      leg.J_leg.col(k) = axis.cross(leg.p_foot - Eigen::Map<const Vec3>(d.xanchor + 3 * joint));
      state.qvel[6 + 3 * i + k] = d.qvel[ids[i].dof[k]];
    }
    leg.v_foot = leg.J_base * state.qvel.head<6>() + leg.J_leg * state.qvel.segment<3>(6 + 3 * i);
    leg.normal_force_n = contacts.foot_n[i];
  }
}

void World::Impl::ReadContacts() {
  contacts = {};
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    const auto g1 = static_cast<size_t>(contact.geom1), g2 = static_cast<size_t>(contact.geom2);
    const size_t g = link_of_geom[g1] == Link::kStatic ? g2 : g1;
    mjtNum force[6];
    mj_contactForce(model.get(), data.get(), c, force);
    switch (link_of_geom[g]) {
      case Link::kFoot:
        contacts.foot_n[static_cast<size_t>(leg_of_foot[g])] += force[0];
        break;
      case Link::kShank:
        contacts.shank_n = std::max(contacts.shank_n, force[0]);
        break;
      case Link::kBody:
        contacts.body_n = std::max(contacts.body_n, force[0]);
        break;
      case Link::kStatic:
        break;
    }
  }
}

World::World(const scenes::SceneSpec& scene, const robots::RobotSpec& robot)
    : impl_(std::make_unique<Impl>(scene, robot)) {}
World::~World() = default;

void World::Place(const core::Pose& T_map_base, const Vec12& joints) {
  mjData& d = *impl_->data;
  const Eigen::Quaterniond q(T_map_base.linear());
  Eigen::Map<Vec3>(d.qpos) = T_map_base.translation();
  Eigen::Map<Eigen::Vector4d>(d.qpos + 3) << q.w(), q.x(), q.y(), q.z();
  for (int i = 0; i < kLegs; ++i) {
    for (int k = 0; k < 3; ++k) d.qpos[impl_->ids[i].qpos[k]] = joints[3 * i + k];
  }
  mju_zero(d.qvel, kDofs);
  impl_->steps_to_activation = 0;
  mj_kinematics(impl_->model.get(), &d);
  mj_comPos(impl_->model.get(), &d);
  impl_->ReadState();
}

void World::BeginStep() {
  Impl& w = *impl_;
  if (w.steps_to_activation-- <= 0) {
    w.steps_to_activation = kActivationSteps;
    const Vec3 p = Eigen::Map<const Vec3>(w.data->qpos);
    w.ground->Activate(core::Box3{p, p}.Inflated(kActivationReachM));
  }
  mj_step1(w.model.get(), w.data.get());
  w.ReadState();
}

void World::FinishStep(const Vec12& torque_nm) {
  Impl& w = *impl_;
  for (int i = 0; i < kLegs; ++i) {
    for (int k = 0; k < 3; ++k) {
      w.data->ctrl[w.ids[i].actuator[k]] = std::clamp(torque_nm[3 * i + k], -kTorqueLimitNm, kTorqueLimitNm);
    }
  }
  mj_step2(w.model.get(), w.data.get());
  w.ReadContacts();
  ++w.steps;
  const mjWarningStat* warning = w.data->warning;
  if (warning[mjWARN_CONTACTFULL].number + warning[mjWARN_CNSTRFULL].number > 0) {
    throw std::runtime_error(
        fmt::format("physics ran out of contacts at {:.3f} s: {}", time_s(),
                    mju_warningText(mjWARN_CONTACTFULL, warning[mjWARN_CONTACTFULL].lastinfo)));
  }
}

const RobotState& World::state() const {
  return impl_->state;
}
const LinkContacts& World::contacts() const {
  return impl_->contacts;
}
const LegGeometry& World::leg(int i) const {
  return impl_->geometry[static_cast<size_t>(i)];
}
double World::time_s() const {
  return static_cast<double>(impl_->steps) * kStepS;
}

bool World::Broken() const {
  const mjWarningStat* warning = impl_->data->warning;
  return warning[mjWARN_BADQPOS].number + warning[mjWARN_BADQVEL].number + warning[mjWARN_BADQACC].number > 0;
}

Vec18 World::GeneralisedForce(const Vec18& qdd) const {
  const mjData& d = *impl_->data;
  Vec18 in = qdd, force;
  for (int i = 0; i < kLegs; ++i) {
    for (int k = 0; k < 3; ++k) in[impl_->ids[i].dof[k]] = qdd[6 + 3 * i + k];
  }
  mj_mulM(impl_->model.get(), &d, force.data(), in.data());
  force += Eigen::Map<const Vec18>(d.qfrc_bias) - Eigen::Map<const Vec18>(d.qfrc_passive);
  Vec18 out = force;
  for (int i = 0; i < kLegs; ++i) {
    for (int k = 0; k < 3; ++k) out[6 + 3 * i + k] = force[impl_->ids[i].dof[k]];
  }
  return out;
}

std::optional<double> World::GroundBelow(const Vec3& p_map) const {
  return impl_->ground->Below(p_map);
}

core::Pose World::T_map_base() const {
  const mjtNum* q = impl_->data->qpos;
  return core::MakePose(Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized().toRotationMatrix(),
                        Eigen::Map<const Vec3>(q));
}

std::vector<double> World::qpos() const {
  return {impl_->data->qpos, impl_->data->qpos + impl_->model->nq};
}

const std::vector<core::TriMesh>& World::body_meshes() const {
  return impl_->meshes;
}

void World::BodyPoses(std::vector<core::Pose>* T_map_body) const {
  T_map_body->clear();
  for (const int b : impl_->bodies) {
    const mjtNum* q = impl_->data->xquat + 4 * b;
    T_map_body->push_back(core::MakePose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
                                         Eigen::Map<const Vec3>(impl_->data->xpos + 3 * b)));
  }
}

void World::PushBase(const Vec3& force_n) {
  Eigen::Map<Vec3>(impl_->data->xfrc_applied + 6 * impl_->base) = force_n;
}

}  // namespace atlas::sim

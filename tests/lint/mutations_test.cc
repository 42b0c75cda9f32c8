// The planted faults of tests/mutations, kept applicable: each names a place that is there once and a test
// that is there. tests/mutations/run plants them.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tests/support/source_tree.h"

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = atlas::tests::SourceTree();
const std::vector<std::string> kRooms = {"core",    "scenes",  "robots",     "sim",
                                         "mapping", "planner", "experiments"};

std::string Read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

/// White space does not count, so that formatting moves nothing away from its fault.
std::string Packed(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isspace(c) != 0; });
  return text;
}

size_t CountOf(const std::string& needle, const std::string& text) {
  size_t count = 0;
  for (size_t at = text.find(needle); at != std::string::npos; at = text.find(needle, at + 1)) ++count;
  return count;
}

struct Fault {
  fs::path path;
  std::string room;
  YAML::Node node;
  std::string Get(const std::string& key) const { return node[key] ? node[key].as<std::string>() : ""; }
};

const std::vector<Fault>& Faults() {
  static const std::vector<Fault> faults = [] {
    std::vector<Fault> found;
    for (const std::string& room : kRooms) {
      for (const auto& file : fs::directory_iterator(kRoot / "tests/mutations" / room)) {
        found.push_back({file.path(), room, YAML::LoadFile(file.path().string())});
      }
    }
    return found;
  }();
  return faults;
}

/// All tests of a room's program and of the laws, as "Suite.Name" and as "Suite".
std::set<std::string> TestsOf(const std::string& room) {
  std::set<std::string> names;
  for (const fs::path& folder : {kRoot / "tests/unit" / room, kRoot / "tests/laws"}) {
    for (const auto& file : fs::directory_iterator(folder)) {
      if (file.path().extension() != ".cc") continue;
      const std::string text = Packed(Read(file.path()));
      for (const std::string macro : {"TEST(", "TEST_F(", "TEST_P(", "TYPED_TEST("}) {
        for (size_t at = text.find(macro); at != std::string::npos; at = text.find(macro, at + 1)) {
          const size_t from = at + macro.size(), comma = text.find(',', from), end = text.find(')', from);
          names.insert(text.substr(from, comma - from));
          names.insert(text.substr(from, comma - from) + "." + text.substr(comma + 1, end - comma - 1));
        }
      }
    }
  }
  return names;
}

TEST(Mutations, AreSixtyOrMoreOverAllRooms) {
  std::map<std::string, int> count;
  std::set<std::string> names;
  for (const Fault& fault : Faults()) {
    ++count[fault.room];
    EXPECT_TRUE(names.insert(fault.path.stem()).second) << fault.path << ": the name is taken";
  }
  for (const std::string& room : kRooms) EXPECT_GE(count[room], 5) << room;
  EXPECT_GE(names.size(), 60u);
}

TEST(Mutations, EachSaysWhatItIsAndReplacesATextThatStandsInItsFileOnce) {
  for (const Fault& fault : Faults()) {
    EXPECT_GT(fault.Get("what").size(), 15u) << fault.path;
    const fs::path file = kRoot / fault.Get("file");
    ASSERT_TRUE(fs::is_regular_file(file)) << fault.path << ": no file " << file;
    const std::string from = Packed(fault.Get("old")), to = Packed(fault.Get("new"));
    ASSERT_FALSE(from.empty()) << fault.path;
    EXPECT_NE(from, to) << fault.path;
    EXPECT_EQ(CountOf(from, Packed(Read(file))), 1u)
        << fault.path << ": the old text must stand in " << fault.Get("file") << " exactly once";
  }
}

TEST(Mutations, EachNamesATestOfItsRoomThatShallSeeIt) {
  std::map<std::string, std::set<std::string>> tests;
  for (const std::string& room : kRooms) tests[room] = TestsOf(room);
  for (const Fault& fault : Faults()) {
    EXPECT_TRUE(tests.at(fault.room).count(fault.Get("seen_by")) > 0)
        << fault.path << ": no test " << fault.Get("seen_by");
  }
}

}  // namespace

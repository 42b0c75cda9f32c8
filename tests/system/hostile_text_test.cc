// Control characters: refused where they enter, shown where they are told of, never sent.
#include "tests/support/command_line.h"

namespace {

using atlas::tests::Outcome;

class HostileText : public atlas::tests::CommandLine {
 protected:
  /// One refusal that shows `shown` and sends nothing that a terminal acts on.
  void ExpectShown(const std::string& arguments, const std::string& shown) {
    ExpectRefusal(arguments, {shown});
    for (const char c : Atlas(arguments).text) {
      EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 || c == '\n')
          << arguments << ": " << static_cast<int>(c);
    }
  }
};

TEST_F(HostileText, IsRefusedInEveryArgument) {
  const std::string evil = R"sh("$(printf 'a\033[2Jb\nc')")sh", shown = "'a\\x1b[2Jb\\nc'";
  for (const std::string head : {"run ", "explain ", "list ", "render ", "report ", "sweep ", "record ",
                                 "bench ", "map --scans ", "mesh ", "eval ", "export ", "posegraph ", ""}) {
    ExpectShown(head + evil, shown);
  }
  ExpectShown("run car --out " + evil, shown);
  ExpectShown("map --scans x --out " + evil, shown);
  ExpectShown("run car --set \"$(printf 'scene=a\\nb')\"", "'scene=a\\nb'");
  ExpectShown("run car --set=\"$(printf 'scene=\\233')\"", "\\x9b");
}

TEST_F(HostileText, IsShownInMessagesAboutFiles) {
  Write("keys.yaml", "scene: car\n\"pla\\e[31mner\": x\n");
  ExpectShown("run keys.yaml", "keys.yaml:2: holds a control character: 'pla\\x1b[31mner'");
  Write("values.yaml", "scene: \"a\\nb\"\n");
  ExpectShown("run values.yaml", "values.yaml:1: holds a control character: 'a\\nb'");
  Write("sweep.yaml", "experiments: [car]\nseeds: 1\nset: [\"mission.max_scans=3\\ntouch x\"]\n");
  ExpectShown("sweep sweep.yaml", "sweep.yaml:3");
  Write("scene.yaml",
        "object_box: {min: [-1, -1, 0.05], max: [1, 1, 2]}\nspawn: {x: -4, y: 0}\nparts:\n"
        "  - {primitive: box, size: [1, 1, 1], label: \"wa\\e[2Jll\"}\n");
  ExpectShown("run car --set scene=scene.yaml", "\\x1b[2J");
  Write("cloud.ply",
        "ply\nformat ascii 1.0\ncomment \033]0;x\a\nelement vertex 1\nproperty \033[2Jfloat "
        "x\nend_header\n0\n");
  ExpectShown("map --scans cloud.ply", "\\x1b[2Jfloat");
  ExpectShown("eval cloud.ply --truth cloud.ply", "\\x1b[2Jfloat");
}

TEST_F(HostileText, IsRefusedInSummariesAndNamesOfScans) {
  std::filesystem::create_directories(dir_ / "run");
  Write("run/summary.json", "{\"experiment\": \"x\\u001b[2J\", \"status\": \"completed\"}");
  const Outcome report = Atlas("report run");
  EXPECT_EQ(report.exit_code, 2);
  EXPECT_NE(report.text.find("x\\x1b[2J"), std::string::npos) << report.text;
  EXPECT_EQ(report.text.find('\033'), std::string::npos);
  std::filesystem::create_directories(dir_ / "scans");
  Write("scans/1\n.pcd", "");
  ExpectShown("map --scans scans", "'1\\n.pcd'");
}

}  // namespace

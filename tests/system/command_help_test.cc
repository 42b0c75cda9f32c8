// What the program says about itself: help, version, lists, completion.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/command_line.h"

namespace {

using atlas::tests::CommandLine;
using atlas::tests::Outcome;

const std::vector<std::string> kCommands = {"run",    "render", "explain",   "list",       "check", "sweep",
                                            "report", "record", "bench",     "map",        "slam",  "mesh",
                                            "eval",   "export", "posegraph", "completion", "help"};

bool Holds(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

std::vector<std::string> FirstWords(const std::string& text) {
  std::istringstream lines(text);
  std::vector<std::string> words;
  for (std::string line; std::getline(lines, line);) words.push_back(line.substr(0, line.find(' ')));
  return words;
}

TEST_F(CommandLine, AloneItPrintsItsHelp) {
  const Outcome alone = Atlas(""), asked = Atlas("--help");
  EXPECT_EQ(alone.exit_code, 0);
  EXPECT_EQ(alone.text, asked.text);
  for (const std::string& command : kCommands) EXPECT_TRUE(Holds(alone.text, "\n  " + command)) << command;
  EXPECT_TRUE(Holds(alone.text, "./atlas test"));
}

TEST_F(CommandLine, VersionIsThatOfTheProject) {
  const Outcome outcome = Atlas("--version");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.text.find("atlas "), 0u) << outcome.text;
  EXPECT_TRUE(Holds(atlas::core::ReadFile(atlas::tests::SourceTree() / "CMakeLists.txt"),
                    "VERSION " + FirstWords(outcome.text.substr(6)).at(0)))
      << outcome.text;
}

TEST_F(CommandLine, HelpShowsDefaultsInPlainText) {
  for (const std::string& command : kCommands) {
    const Outcome outcome = Atlas(command + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_FALSE(Holds(outcome.text, "{")) << outcome.text;
    EXPECT_FALSE(Holds(outcome.text, "[\"\"]") || Holds(outcome.text, "[[]]")) << outcome.text;
    EXPECT_EQ(Atlas("help " + command).text, outcome.text) << command;
  }
  const std::vector<std::pair<std::string, std::string>> defaults = {
      {"run", "1"},         {"render", "8"},  {"render", "960x540"}, {"bench", "1"},   {"sweep", "1"},
      {"record", "os1_64"}, {"record", "on"}, {"map", "0.065"},      {"map", "60"},    {"map", "occupancy"},
      {"map", "dropout"},   {"map", "auto"},  {"eval", "0.02"},      {"eval", "mesh"}, {"eval", "0.5"}};
  for (const auto& [command, value] : defaults) {  // releases of the parser write "=8 " or "[8]"
    const std::string text = Atlas(command + " --help").text;
    EXPECT_TRUE(Holds(text, "=" + value + " ") || Holds(text, "=" + value + "\n") ||
                Holds(text, "[" + value + "]"))
        << command << " lacks " << value << "\n"
        << text;
  }
}

TEST_F(CommandLine, UnknownOptionsSuggestTheNearOne) {
  ExpectRefusal("run helicopter --sed 1", {"run: unknown option '--sed'", "did you mean '--seed'"});
  ExpectRefusal("run helicopter --thread=2", {"'--thread'", "did you mean '--threads'"});
  ExpectRefusal("run -seed 1 helicopter", {"'-seed'", "did you mean '--seed'"});
  ExpectRefusal("--versio", {"did you mean '--version'"});
  ExpectRefusal("bench mapper --no-octomop", {"did you mean '--no-octomap'"});
  ExpectRefusal("map --scans . --field tsfd", {"--field", "did you mean 'tsdf'"});
  ExpectRefusal("record car --lidar vlp61", {"--lidar", "did you mean 'vlp16'"});
  ExpectRefusal("record car --noise onn", {"--noise", "did you mean 'on'"});
  ExpectRefusal("sweep table_31", {"did you mean 'table_3_1'"});
  ExpectRefusal("bench lidra", {"did you mean 'lidar'"});
  ExpectRefusal("completion bsah", {"did you mean 'bash'"});
  ExpectRefusal("help rnu", {"did you mean 'run'"});
}

TEST_F(CommandLine, NegativeNumbersAreNoOptions) {
  ExpectRefusal("render nowhere --still --eye -1 -0.5 2 --target -1 0 1", {"nowhere"});
}

TEST_F(CommandLine, EveryKindThatIsListedHasEntries) {
  const Outcome kinds = Atlas("list");
  ASSERT_EQ(kinds.exit_code, 0);
  const std::vector<std::string> names = FirstWords(kinds.text);
  EXPECT_GE(names.size(), 11u);
  for (const std::string& kind : names) {
    const Outcome outcome = Atlas("list " + kind);
    EXPECT_EQ(outcome.exit_code, 0) << kind;
    EXPECT_GT(outcome.text.size(), 1u) << kind;
  }
  EXPECT_TRUE(Holds(Atlas("list sweeps").text, "table_3_2"));
  EXPECT_TRUE(Holds(Atlas("list lidars").text, "os1_64  64 beams from -16.6 to 16.6 deg"));
  EXPECT_TRUE(Holds(Atlas("list routes").text, "campus_flight"));
  EXPECT_TRUE(Holds(Atlas("list labels").text, "\ngrating"));
}

TEST_F(CommandLine, BashCompletesCommandsOptionsAndNames) {
  Write("check.sh", R"(source ./completion.sh
complete -p atlas > /dev/null || exit 1
try() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _atlas; echo "$*: ${COMPREPLY[*]}"; }
try ./atlas sw
try atlas run helicopter_g
try atlas run helicopter --se
try atlas map --field t
try atlas list swe
try atlas sweep table_3_2
try atlas run helicopter --set planner.stop_ra
try atlas run helicopter --out r
)");
  const Outcome outcome = Atlas("completion bash > completion.sh && bash check.sh");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.text,
            "./atlas sw: sweep\n"
            "atlas run helicopter_g: helicopter_grating\n"
            "atlas run helicopter --se: --seed --set\n"
            "atlas map --field t: tsdf\n"
            "atlas list swe: sweeps\n"
            "atlas sweep table_3_2: table_3_2\n"
            "atlas run helicopter --set planner.stop_ra: planner.stop_ratio=\n"
            "atlas run helicopter --out r: \n");
}

}  // namespace

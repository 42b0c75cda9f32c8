// Nothing so long that it has to be scrolled: files up to 400 lines, functions up to 60.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/source_tree.h"

namespace {

namespace fs = std::filesystem;

constexpr size_t kFileLines = 400, kFunctionLines = 60;

std::vector<std::string> LinesOf(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

size_t IndentOf(const std::string& line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

/// Where the statement begins that ends on this line: below a blank line or the end of another statement.
size_t BeginOf(const std::vector<std::string>& lines, size_t last) {
  static const std::regex ends("^\\s*(#|//).*|.*[;{}]\\s*(//.*)?$|^\\s*$|^\\s*(public|private|protected):$");
  size_t first = last;
  while (first > 0 && !std::regex_match(lines[first - 1], ends)) --first;
  return first;
}

struct Function {
  size_t first = 0, lines = 0;
};

/// The functions of a source laid out by clang-format: a block that a parameter list opens ends at the brace
/// on the column where the statement begins. What stands inside another function is counted with it.
std::vector<Function> FunctionsOf(const std::vector<std::string>& lines) {
  static const std::regex other(
      "^\\s*(if|for|while|switch|else|do|catch|namespace|struct|class|enum|union|return|extern)\\b.*");
  std::vector<Function> functions;
  for (size_t i = 0; i < lines.size(); ++i) {
    if (!lines[i].ends_with('{')) continue;
    const size_t first = BeginOf(lines, i);
    std::string statement;
    for (size_t k = first; k <= i; ++k) statement += lines[k];
    if (statement.find('(') == std::string::npos || std::regex_match(statement, other)) continue;
    const std::string end = std::string(IndentOf(lines[first]), ' ') + "}";
    size_t last = i + 1;
    while (last < lines.size() && lines[last].rfind(end, 0) != 0) ++last;
    functions.push_back({first + 1, last - first + 1});
    i = last;
  }
  return functions;
}

std::vector<fs::path> AllSources() {
  std::vector<fs::path> files;
  for (const char* room : {"core", "scenes", "robots", "sim", "mapping", "planner", "experiments", "tests"}) {
    for (const auto& file : fs::recursive_directory_iterator(atlas::tests::SourceTree() / room)) {
      const std::string extension = file.path().extension();
      if (extension == ".h" || extension == ".cc") files.push_back(file.path());
    }
  }
  return files;
}

TEST(Sizes, FunctionsAreFoundWithTheirLength) {
  const std::vector<std::string> lines = {"namespace a {",
                                          "",
                                          "int Twice(int x) {",
                                          "  if (x > 0) {",
                                          "    return 2 * x;",
                                          "  }",
                                          "  return 0;",
                                          "}",
                                          "struct B {",
                                          "  B(int x,",
                                          "    int y)",
                                          "      : x_(x) {",
                                          "    const int z = x + y;",
                                          "  }",
                                          "  int Get() const {",
                                          "    return x_;",
                                          "  }",
                                          "  int x_;",
                                          "};",
                                          "}  // namespace a"};
  const std::vector<Function> functions = FunctionsOf(lines);
  ASSERT_EQ(functions.size(), 3u);
  EXPECT_EQ(functions[0].lines, 6u);
  EXPECT_EQ(functions[1].lines, 5u);
  EXPECT_EQ(functions[2].lines, 3u);
}

TEST(Sizes, NoFileAboveFourHundredLinesNoFunctionAboveSixty) {
  size_t functions = 0;
  for (const fs::path& file : AllSources()) {
    const std::vector<std::string> lines = LinesOf(file);
    EXPECT_LE(lines.size(), kFileLines) << file;
    for (const Function& f : FunctionsOf(lines)) {
      EXPECT_LE(f.lines, kFunctionLines) << file << ":" << f.first;
      ++functions;
    }
  }
  EXPECT_GT(functions, 2000u);
}

}  // namespace

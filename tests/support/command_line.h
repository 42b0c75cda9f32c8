// The program run as a user runs it, in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/source_tree.h"

namespace atlas::tests {

struct Outcome {
  int exit_code = -1;
  std::string text;
};

class CommandLine : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(dir_); }
  void TearDown() override { std::filesystem::remove_all(dir_); }

  /// What `atlas ARGUMENTS` answers, run in the test's folder.
  Outcome Atlas(const std::string& arguments) {
    const std::string command =
        "cd '" + dir_.string() + "' && '" + AtlasBinary().string() + "' " + arguments + " 2>&1 < /dev/null";
    FILE* pipe = popen(command.c_str(), "r");
    Outcome outcome;
    std::array<char, 4096> buffer;
    while (const size_t n = fread(buffer.data(), 1, buffer.size(), pipe))
      outcome.text.append(buffer.data(), n);
    const int status = pclose(pipe);
    outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
  }

  void Write(const std::string& name, const std::string& text) { std::ofstream(dir_ / name) << text; }

  /// Exit code 2 and one line, which holds these words.
  void ExpectRefusal(const std::string& arguments, const std::vector<std::string>& mentions) {
    const Outcome outcome = Atlas(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << "\n" << outcome.text;
    std::istringstream lines(outcome.text);
    size_t count = 0;
    for (std::string line; std::getline(lines, line);)
      count += line.find_first_not_of(" \r") != std::string::npos;
    EXPECT_EQ(count, 1u) << arguments << "\n" << outcome.text;
    for (const std::string& word : mentions) {
      EXPECT_NE(outcome.text.find(word), std::string::npos) << arguments << "\n"
                                                            << outcome.text << "\nlacks " << word;
    }
  }

  std::filesystem::path dir_ =
      std::filesystem::temp_directory_path() / ("atlas_cli_" + std::to_string(::getpid()));
};

}  // namespace atlas::tests

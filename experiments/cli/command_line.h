// The command line: each group of commands adds its own to the parser. What includes this is compiled as one
// unit (experiments/CMakeLists.txt), since the parser's header is slow to compile.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace atlas::experiments {

/// What the chosen command does; returns the process's exit code.
using Action = std::function<int()>;

/// Each adds commands whose parsing sets `action`. `threads` is the default of their --threads.
void AddRunCommands(CLI::App* app, int threads, Action* action);    // run, render, explain, list
void AddSweepCommands(CLI::App* app, int threads, Action* action);  // sweep, report, record, bench
void AddMapCommands(CLI::App* app, int threads, Action* action);  // map, slam, mesh, eval, export, posegraph
void AddShellCommands(CLI::App* app, Action* action);             // completion, help

/// Accepts numbers from `least` to `most`; not NaN, which is neither below nor above.
CLI::Validator Between(double least, double most);
/// --out, which may not be empty: a variable that is not set would write to the default place.
CLI::Option* AddOut(CLI::App* command, std::filesystem::path* out, const std::string& doc);
/// --threads, 1 to 64.
void AddThreads(CLI::App* command, int* threads);
/// Accepts seeds (0 to kGreatestSeed) only.
CLI::Validator SeedCheck();
/// Accepts these names only; others are answered with the near one.
CLI::Validator OneOf(const std::string& kind, const std::vector<std::string>& names);

/// The options of `app` as they are written: "--seed", "-h".
std::vector<std::string> OptionsOf(const CLI::App& app);
/// @throws InputError for an unknown command or option, naming the near one.
void CheckNames(const CLI::App& app, int argc, const char* const* argv);

/// A script for bash that completes the commands of `app`, their options and the names in the catalogues.
std::string BashCompletion(const CLI::App& app);

}  // namespace atlas::experiments

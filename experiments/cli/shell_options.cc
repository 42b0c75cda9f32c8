#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <iostream>
#include <memory>

#include "core/errors.h"
#include "experiments/cli/command_line.h"
#include "experiments/cli/commands.h"
#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {
namespace {

std::vector<std::string> CommandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

/// The names that an argument of OneOf accepts, from its description "TEXT:a|b"; none for other arguments.
std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t start = type.find(':');
  if (start == std::string::npos || type.find('|') == std::string::npos) return {};
  return CLI::detail::split(type.substr(start + 1), '|');
}

/// What may stand for a command's first argument, besides a file.
std::vector<std::string> SubjectsOf(const std::string& command, const CLI::App& app) {
  if (command == "run") return NamesOfKind("experiments");
  if (command == "explain") {
    std::vector<std::string> names = NamesOfKind("experiments");
    names.emplace_back("map");
    return names;
  }
  if (command == "sweep") return NamesOfKind("sweeps");
  if (command == "record" || command == "render" || command == "check") return NamesOfKind("scenes");
  if (command == "list") return ListKinds();
  if (command == "bench") return {"lidar", "mapper", "motion", "correction", "odometry", "places"};
  if (command == "completion") return {"bash"};
  if (command == "help") return CommandsOf(app);
  return {};
}

/// "planner.gain=" for every parameter of any experiment: each planner has its own.
std::vector<std::string> Assignments() {
  std::vector<std::string> words;
  for (const std::string& experiment : NamesOfKind("experiments")) {
    for (const core::ParamRow& row : LoadExperiment(experiment, {}).rows) {
      const std::string word = row.path + "=";
      if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
    }
  }
  return words;
}

int CompletionCommand(const CLI::App& app, const std::string& shell) {
  if (shell != "bash") throw core::InputError(core::UnknownName("shell", shell, {"bash"}));
  std::cout << BashCompletion(app);
  return 0;
}

}  // namespace

CLI::Validator Between(double least, double most) {
  return {[=](std::string& value) {
            double number = 0.0;
            const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
            const bool whole = error == std::errc{} && end == value.data() + value.size();
            if (whole && number >= least && number <= most) return std::string();
            return fmt::format("'{}' is not a number from {} to {}", value, least, most);
          },
          fmt::format("[{}, {}]", least, most)};
}

CLI::Option* AddOut(CLI::App* command, std::filesystem::path* out, const std::string& doc) {
  return command->add_option("--out", *out, doc)->check([](const std::string& value) {
    return value.empty() ? std::string("must not be empty") : std::string();
  });
}

void AddThreads(CLI::App* command, int* threads) {
  command->add_option("--threads", *threads, "threads; results do not depend on it")->check(Between(1, 64));
}

CLI::Validator SeedCheck() {
  return {[](std::string& value) {
            int64_t seed = -1;
            const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), seed);
            const bool whole = error == std::errc{} && end == value.data() + value.size();
            if (!whole || seed < 0 || seed > kGreatestSeed)
              return fmt::format("expected a whole number from 0 to {}, found '{}'", kGreatestSeed, value);
            value = std::to_string(seed);  // without leading zeros, which the parser takes for octal
            return std::string();
          },
          fmt::format("in [0 - {}]", kGreatestSeed)};
}

CLI::Validator OneOf(const std::string& kind, const std::vector<std::string>& names) {
  return {[=](std::string& value) {
            const bool known = std::find(names.begin(), names.end(), value) != names.end();
            return known ? std::string() : core::UnknownName(kind, value, names);
          },
          fmt::format("{}", fmt::join(names, "|"))};
}

std::vector<std::string> OptionsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

void CheckNames(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* scope = &app;
  std::string where;
  int first = 1;
  if (argc > 1 && argv[1][0] != '-') {
    const std::vector<std::string> commands = CommandsOf(app);
    if (std::find(commands.begin(), commands.end(), argv[1]) == commands.end())
      throw core::InputError(core::UnknownName("command", argv[1], commands));
    scope = app.get_subcommand(argv[1]);
    where = std::string(argv[1]) + ": ";
    first = 2;
  }
  const std::vector<std::string> options = OptionsOf(*scope);
  for (int i = first; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string name = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    const bool number = name.size() > 1 && (name[1] == '.' || (name[1] >= '0' && name[1] <= '9'));
    if (name.size() < 2 || name[0] != '-' || number) continue;
    if (std::find(options.begin(), options.end(), name) == options.end())
      throw core::InputError(where + core::UnknownName("option", name, options));
  }
}

std::string BashCompletion(const CLI::App& app) {
  const auto row = [](const std::string& pattern, const std::vector<std::string>& words) {
    return words.empty() ? "" : fmt::format("    {}) words=\"{}\" ;;\n", pattern, fmt::join(words, " "));
  };
  std::string values, subjects, options;
  for (const CLI::App* command : app.get_subcommands({})) {
    const std::string& name = command->get_name();
    subjects += row(name, SubjectsOf(name, app));
    options += row(name, OptionsOf(*command));
    for (const CLI::Option* option : command->get_options())
      values += row(name + ":" + option->get_name(), ChoicesOf(*option));
  }
  std::vector<std::string> first = CommandsOf(app);
  first.insert(first.end(), {"test", "packages", "--help", "--version"});
  return fmt::format(R"(# Completion of atlas in bash: source <(./atlas completion bash)
_atlas() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}} words=
  COMPREPLY=()
  case $command:$prev in
{}    run:--set|explain:--set) words="{}"; compopt -o nospace 2>/dev/null ;;
    *:--out|*:--json|*:--poses|*:--scans|*:--truth|*:--route) return ;;
  esac
  if [ "$COMP_CWORD" -eq 1 ]; then
    words="{}"
  elif [[ $cur == -* ]]; then
    case $command in
{}    test) words="--sanitize --tsan" ;;
    esac
  elif [ "$COMP_CWORD" -eq 2 ]; then
    case $command in
{}    esac
  fi
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
}}
complete -o default -F _atlas atlas
)",
                     values, fmt::join(Assignments(), " "), fmt::join(first, " "), options, subjects);
}

void AddShellCommands(CLI::App* app, Action* action) {
  const auto shell = std::make_shared<std::string>("bash"), topic = std::make_shared<std::string>();
  CLI::App* completion =
      app->add_subcommand("completion", "Completion for a shell: source <(./atlas completion bash)");
  completion->add_option("shell", *shell, "bash");
  completion->callback([=] { *action = [=] { return CompletionCommand(*app, *shell); }; });
  CLI::App* help = app->add_subcommand("help", "Options of a command");
  help->add_option("command", *topic, "which (default: all commands)");
  help->callback([=] {
    *action = [=] {
      if (!topic->empty()) CheckNames(*app, 2, std::vector<const char*>{"atlas", topic->c_str()}.data());
      std::cout << (topic->empty() ? app->help() : app->get_subcommand(*topic)->help("atlas"));
      return 0;
    };
  });
}

}  // namespace atlas::experiments

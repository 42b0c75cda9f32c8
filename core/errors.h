// The three kinds of failure: assert (our bug), InputError (bad input, found at construction or load), and
// enums or optionals for expected outcomes.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace atlas::core {

/// Bad input from a user: config, scene, robot, scan, map file or command line. `what()` is one line (by
/// core::Printable, since messages quote what files hold) that names the file, the field, the value and the
/// limit. The command line prints it and exits with code 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::string message);
};

/// "unknown gain 'foo'; did you mean 'fog'? (valid: a, b, c)": the message for a name missing from a
/// catalogue.
std::string UnknownName(std::string_view kind, std::string_view name, const std::vector<std::string>& valid);

/// The entry of `valid` within a small edit distance of `name`, or "" when none is near.
std::string NearestName(std::string_view name, const std::vector<std::string>& valid);

}  // namespace atlas::core

// MuJoCo's fatal errors as exceptions.
#pragma once

namespace atlas::sim {

/// Makes fatal MuJoCo errors throw std::runtime_error (the library's own answer is to wait for a key and
/// exit) and silences warnings, which the data counts anyway. Idempotent and thread-safe.
void InstallMujocoHandlers();

}  // namespace atlas::sim

#include "sim/world/mujoco_guard.h"

#include <mujoco/mujoco.h>

#include <mutex>
#include <stdexcept>
#include <string>

namespace atlas::sim {
namespace {

void ThrowError(const char* message) {
  throw std::runtime_error(std::string("MuJoCo: ") + message);
}
void IgnoreWarning(const char*) {}

}  // namespace

void InstallMujocoHandlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = &ThrowError;
    mju_user_warning = &IgnoreWarning;
  });
}

}  // namespace atlas::sim

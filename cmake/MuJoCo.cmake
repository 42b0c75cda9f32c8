# MuJoCo by header and library: the CMake package that Debian ships names a folder that does not exist.
find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h REQUIRED)
find_library(MUJOCO_LIBRARY mujoco REQUIRED)
add_library(mujoco::mujoco UNKNOWN IMPORTED)
set_target_properties(mujoco::mujoco PROPERTIES IMPORTED_LOCATION ${MUJOCO_LIBRARY}
                                                INTERFACE_INCLUDE_DIRECTORIES ${MUJOCO_INCLUDE_DIR})

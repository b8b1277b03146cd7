# Man page and completions, written by the program itself; Debian packages by `cpack -G DEB` (scripts/package.sh).
set(forms "${PROJECT_BINARY_DIR}/forms")
file(MAKE_DIRECTORY "${forms}")
add_custom_command(
  OUTPUT "${forms}/deepslam.1" "${forms}/deepslam.bash" "${forms}/_deepslam" "${forms}/deepslam.fish"
  COMMAND deepslam man > "${forms}/deepslam.1"
  COMMAND deepslam completion bash > "${forms}/deepslam.bash"
  COMMAND deepslam completion zsh > "${forms}/_deepslam"
  COMMAND deepslam completion fish > "${forms}/deepslam.fish"
  DEPENDS deepslam
  COMMENT "Writing man page and completions"
  VERBATIM)
add_custom_target(deepslam_forms ALL DEPENDS "${forms}/deepslam.1")
install(FILES "${forms}/deepslam.1" DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES "${forms}/deepslam.bash" DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME deepslam)
install(FILES "${forms}/_deepslam" DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES "${forms}/deepslam.fish" DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)

# The version stands in the sources, which also build without CMake's.
file(STRINGS src/deepslam/stages/plan.h tool_version REGEX "kToolVersion = \"")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" tool_version "${tool_version}")
if(NOT tool_version STREQUAL PROJECT_VERSION)
  message(FATAL_ERROR "stages/plan.h says version ${tool_version}, CMakeLists.txt says ${PROJECT_VERSION}")
endif()

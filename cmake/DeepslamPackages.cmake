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

# What the packages say about licences: ours, what is linked, and the full texts that are asked for.
get_filename_component(onnxruntime_folder "${ONNXRUNTIME_LIBRARY}" DIRECTORY)
set(copyright "")
function(deepslam_append_text title)
  foreach(file IN LISTS ARGN)
    if(EXISTS "${file}")
      file(READ "${file}" text)
      string(APPEND copyright "\n\n==== ${title} ====\n\n${text}")
      set(copyright "${copyright}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(WARNING "no licence text of ${title}: a package that is given to others needs it")
endfunction()
deepslam_append_text("deepslam" "${PROJECT_SOURCE_DIR}/LICENSE")
deepslam_append_text("ONNX Runtime, lib/deepslam/libonnxruntime.so.1" "${onnxruntime_folder}/../LICENSE")
if(DEEPSLAM_THREE_DIR)
  deepslam_append_text("three.js, in bin/deepslam" "${DEEPSLAM_THREE_DIR}/LICENSE")
endif()
file(READ NOTICE notice)
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/copyright" @ONLY CONTENT "@notice@
On Debian the texts of the GNU licences and of Apache-2.0 are in /usr/share/common-licenses.
@copyright@")
install(FILES "${PROJECT_BINARY_DIR}/copyright" DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/deepslam)
install(FILES "${PROJECT_BINARY_DIR}/copyright" DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/deepslam-dev COMPONENT development)

# deepslam: the program. deepslam-dev: libraries, headers, find_package.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "deepslam")
set(CPACK_PACKAGE_CONTACT "The deepslam authors <deepslam@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE zstd)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME deepslam)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
# After the project's own line.
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "deepslam takes a recorded RGB-D sequence of a room to a compact glTF scene in
which every piece of furniture is a closed, metric, labelled mesh.
.
The detector's weights are not in this package: deepslam-fetch-weights gets
them. deepslam-demo renders a sample capture and reconstructs it.")
# Computed from what the program links. ONNX Runtime comes along, so it is looked for where it is taken from.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/installed/lib")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "sweethome3d-furniture")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "npm, slurm-client")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME deepslam-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Static libraries, headers and find_package(deepslam).")
# What deepslamConfig.cmake looks for.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "deepslam (= ${PROJECT_VERSION}), cmake, libblosc-dev, libceres-dev, \
libcgal-dev, libdraco-dev, libeigen3-dev, libembree-dev, libfmt-dev, libjpeg-dev, libmeshoptimizer-dev, libnanoflann-dev, libopen3d-dev, \
libopencv-dev, libopenexr-dev, libopenmesh-dev, libpng-dev, libprotobuf-dev, libsqlite3-dev, libssl-dev, libtbb-dev, libtiff-dev, libtinyobjloader-dev, libwebp-dev, libyaml-cpp-dev, libzip-dev, nlohmann-json3-dev, zlib1g-dev")
include(CPack)

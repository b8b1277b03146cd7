# What `cmake --install` puts where. All places are relative to the prefix, so that an installed tree can be moved:
#
#   bin/deepslam, deepslam-tools, deepslam-demo, deepslam-fetch-weights
#   lib/deepslam/libonnxruntime.so.1        ours alone; the program finds both by its run path $ORIGIN/../lib/deepslam
#   lib/deepslam/libdeepslam_video.so       loaded when a video is opened
#   share/deepslam/configs, scripts         the same two folders as in the source tree
#   share/man, share/bash-completion, ...   written by the program itself (DeepslamPackages.cmake)
#   share/doc/deepslam
#   lib/libdeepslam_<module>.a, include/deepslam/<module>, lib/cmake/deepslam       component `development`
set(CMAKE_INSTALL_LIBDIR lib)  # not lib/<triplet>: the prefix decides nothing
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME runtime)
set(DEEPSLAM_PRIVATE_LIBDIR lib/deepslam)
set(DEEPSLAM_CMAKEDIR lib/cmake/deepslam)
# What is loaded, not linked, lies in the build tree as where it is installed; every program there finds it by its run path.
set(DEEPSLAM_BUILD_MODULES "${PROJECT_BINARY_DIR}/${DEEPSLAM_PRIVATE_LIBDIR}")
set(CMAKE_BUILD_RPATH "${DEEPSLAM_BUILD_MODULES}")

# The packages that give the targets which modules link.
set(deepslam_package_of_fmt fmt)
set(deepslam_package_of_TBB TBB)
set(deepslam_package_of_OpenSSL OpenSSL)
set(deepslam_package_of_yaml-cpp yaml-cpp)
set(deepslam_package_of_nlohmann_json nlohmann_json)
set(deepslam_package_of_opencv_core OpenCV)
set(deepslam_package_of_opencv_features2d OpenCV)
set(deepslam_package_of_opencv_imgproc OpenCV)
set(deepslam_package_of_protobuf Protobuf)
set(deepslam_package_of_ZLIB ZLIB)
set(deepslam_package_of_JPEG JPEG)
set(deepslam_package_of_PNG PNG)
set(deepslam_package_of_TIFF TIFF)
set(deepslam_package_of_OpenEXR OpenEXR)
set(deepslam_package_of_SQLite SQLite3)
set(deepslam_package_of_Ceres Ceres)
set(deepslam_package_of_OpenMeshTools OpenMesh)
set(deepslam_package_of_OpenMeshCore OpenMesh)
set(deepslam_package_of_CGAL CGAL)
set(deepslam_package_of_draco draco)
set(deepslam_package_of_tinyobjloader tinyobjloader)
set(deepslam_package_of_nanoflann nanoflann)
set(deepslam_package_of_meshoptimizer meshoptimizer)
set(deepslam_package_of_embree embree)
set(deepslam_package_of_Open3D Open3D)
# Those that deepslamConfig.cmake makes itself.
set(deepslam_package_of_deepslam::onnxruntime onnxruntime)
set(deepslam_package_of_deepslam::blosc blosc)
set(deepslam_package_of_deepslam::libzip libzip)
set(deepslam_package_of_deepslam::webp webp)

# deepslam_install_module(<module> DEPS modules... FENCED libs...)
function(deepslam_install_module module)
  cmake_parse_arguments(MODULE "" "" "DEPS;FENCED" ${ARGN})
  set_target_properties(deepslam_${module} PROPERTIES EXPORT_NAME ${module})
  install(TARGETS deepslam_${module} EXPORT deepslamTargets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}/" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/deepslam/${module}
          COMPONENT development FILES_MATCHING PATTERN "*.h")

  # Packages of this module and of those below it, in the order in which they are to be looked for.
  set(packages "")
  foreach(dep IN LISTS MODULE_DEPS)
    get_property(below GLOBAL PROPERTY deepslam_packages_${dep})
    list(APPEND packages ${below})
  endforeach()
  foreach(lib IN LISTS MODULE_FENCED)
    set(key "${lib}")
    if(NOT DEFINED deepslam_package_of_${key})
      string(REGEX REPLACE "::.*" "" key "${lib}")
    endif()
    if(NOT DEFINED deepslam_package_of_${key})
      message(FATAL_ERROR "${lib}, which module ${module} links, has no package in cmake/DeepslamInstall.cmake")
    endif()
    list(APPEND packages ${deepslam_package_of_${key}})
  endforeach()
  list(REMOVE_DUPLICATES packages)
  set_property(GLOBAL PROPERTY deepslam_packages_${module} ${packages})
  set_property(GLOBAL APPEND PROPERTY deepslam_installed_modules ${module})
endfunction()

# After all modules: the files behind find_package(deepslam).
function(deepslam_install_config)
  get_property(modules GLOBAL PROPERTY deepslam_installed_modules)
  set(DEEPSLAM_MODULE_PACKAGES "")
  foreach(module IN LISTS modules)
    get_property(packages GLOBAL PROPERTY deepslam_packages_${module})
    string(APPEND DEEPSLAM_MODULE_PACKAGES "set(_deepslam_packages_${module} ${packages})\n")
  endforeach()
  set(DEEPSLAM_MODULES "${modules}")
  configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/deepslamConfig.cmake.in"
    "${PROJECT_BINARY_DIR}/deepslamConfig.cmake" INSTALL_DESTINATION ${DEEPSLAM_CMAKEDIR}
    NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  # Before 1.0 headers may change with every minor version.
  write_basic_package_version_file("${PROJECT_BINARY_DIR}/deepslamConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
  install(EXPORT deepslamTargets NAMESPACE deepslam:: DESTINATION ${DEEPSLAM_CMAKEDIR} COMPONENT development)
  install(FILES "${PROJECT_BINARY_DIR}/deepslamConfig.cmake" "${PROJECT_BINARY_DIR}/deepslamConfigVersion.cmake"
          DESTINATION ${DEEPSLAM_CMAKEDIR} COMPONENT development)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/consumer" DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/deepslam/examples
          COMPONENT development)
endfunction()

# The file has its SONAME's name, which is what the loader looks for.
file(REAL_PATH "${ONNXRUNTIME_LIBRARY}" deepslam_onnxruntime_file)
install(FILES "${deepslam_onnxruntime_file}" DESTINATION ${DEEPSLAM_PRIVATE_LIBDIR} RENAME libonnxruntime.so.1
        PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)

install(DIRECTORY "${PROJECT_SOURCE_DIR}/configs" DESTINATION ${CMAKE_INSTALL_DATADIR}/deepslam)
install(PROGRAMS scripts/sample.sh scripts/furniture.sh scripts/fetch_weights.sh
        DESTINATION ${CMAKE_INSTALL_DATADIR}/deepslam/scripts)
install(PROGRAMS scripts/import_recording.py DESTINATION ${CMAKE_INSTALL_DATADIR}/deepslam/scripts)
install(FILES scripts/import_requirements.txt scripts/record3d_recording.py scripts/recording_files.py DESTINATION ${CMAKE_INSTALL_DATADIR}/deepslam/scripts)
install(FILES scripts/npm_files.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/deepslam/scripts)
# dpkg-shlibdeps finds it under that name here.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/installed/lib")
file(CREATE_LINK "${deepslam_onnxruntime_file}" "${PROJECT_BINARY_DIR}/installed/lib/libonnxruntime.so.1" SYMBOLIC)

# Links, since the scripts look for their neighbours from where they are themselves.
foreach(pair "deepslam-demo sample.sh" "deepslam-fetch-weights fetch_weights.sh")
  separate_arguments(pair)
  list(GET pair 0 name)
  list(GET pair 1 script)
  file(CREATE_LINK "../${CMAKE_INSTALL_DATADIR}/deepslam/scripts/${script}" "${PROJECT_BINARY_DIR}/installed/${name}" SYMBOLIC)
  install(FILES "${PROJECT_BINARY_DIR}/installed/${name}" DESTINATION ${CMAKE_INSTALL_BINDIR})
endforeach()
install(FILES README.md LICENSE NOTICE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/deepslam)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/deepslam FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.png")

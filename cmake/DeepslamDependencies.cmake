# Everything but ONNX Runtime comes from Debian's packages (scripts/setup.sh installs all of it).
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(TBB REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenCV REQUIRED COMPONENTS core features2d imgproc imgcodecs videoio)
find_package(Protobuf REQUIRED)
find_package(ZLIB REQUIRED)
find_package(JPEG REQUIRED)
find_package(PNG REQUIRED)
find_package(TIFF REQUIRED)
find_package(OpenEXR CONFIG REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(Ceres REQUIRED)
# CGAL brings a FindOpenMesh of its own that fails here: look for the package's own configuration, first.
find_package(OpenMesh CONFIG REQUIRED)
find_package(CGAL REQUIRED)
find_package(draco REQUIRED)
find_package(tinyobjloader REQUIRED)
find_package(nanoflann REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(embree 3 REQUIRED)
find_package(Open3D REQUIRED)
# It states the compiler's default, and a macro of the command line keeps precompiled headers from being taken.
set_property(TARGET Open3D::Open3D PROPERTY INTERFACE_COMPILE_DEFINITIONS "")

# ONNX Runtime: an installation given by onnxruntime_ROOT, else the one that scripts/setup.sh made.
if(DEFINED ENV{XDG_DATA_HOME})
  set(_deepslam_data "$ENV{XDG_DATA_HOME}/deepslam")
else()
  set(_deepslam_data "$ENV{HOME}/.local/share/deepslam")
endif()
find_path(ONNXRUNTIME_INCLUDE_DIR onnxruntime_cxx_api.h
          HINTS "${onnxruntime_ROOT}" "$ENV{onnxruntime_ROOT}" "${_deepslam_data}/onnxruntime"
          PATH_SUFFIXES include include/onnxruntime include/onnxruntime/core/session)
find_library(ONNXRUNTIME_LIBRARY onnxruntime
             HINTS "${onnxruntime_ROOT}" "$ENV{onnxruntime_ROOT}" "${_deepslam_data}/onnxruntime"
             PATH_SUFFIXES lib)
if(NOT ONNXRUNTIME_INCLUDE_DIR OR NOT ONNXRUNTIME_LIBRARY)
  message(FATAL_ERROR "ONNX Runtime not found: run scripts/setup.sh, or pass -Donnxruntime_ROOT=DIR")
endif()
# Imported under our own name, which deepslamConfig.cmake gives to the copy that is installed with the program.
add_library(deepslam::onnxruntime SHARED IMPORTED)
set_target_properties(deepslam::onnxruntime PROPERTIES
  IMPORTED_LOCATION "${ONNXRUNTIME_LIBRARY}"
  INTERFACE_INCLUDE_DIRECTORIES "${ONNXRUNTIME_INCLUDE_DIR}")

# Found by their files: the packages of Blosc and libwebp have no configuration for CMake, and Debian's
# libzip-config.cmake asks for the command line tools of another package.
#   deepslam_find_library(<name> <header> <library>)
function(deepslam_find_library name header library)
  string(TOUPPER "${name}" upper)
  find_path(${upper}_INCLUDE_DIR ${header} REQUIRED)
  find_library(${upper}_LIBRARY ${library} REQUIRED)
  add_library(deepslam::${name} UNKNOWN IMPORTED GLOBAL)
  set_target_properties(deepslam::${name} PROPERTIES
    IMPORTED_LOCATION "${${upper}_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${${upper}_INCLUDE_DIR}")
endfunction()
deepslam_find_library(blosc blosc.h blosc)
deepslam_find_library(libzip zip.h zip)
deepslam_find_library(webp webp/decode.h webp)

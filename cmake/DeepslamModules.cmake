# One module = one folder = one library deepslam_<module>, alias deepslam::<module>.
#
#   deepslam_module(<module> SOURCES a.cc b.cc DEPS core geometry FENCED OpenCV::core [CGAL])
#
# OPTIMIZE_LESS: the module hands on what others compute. UNITY: several files are compiled as one, where they share what
# takes longest. DEPS are modules and appear in headers; FENCED are third-party libraries that stay in the .cc files.
# scripts/check_layers.py holds the allowed arrows between modules; ctest runs it.

# Sanitizers load libraries in the program's stead, and a RUNPATH is that of its owner alone: a plain RPATH is heeded.
function(deepslam_run_path_for_all target)
  target_link_options(${target} PUBLIC LINKER:--disable-new-dtags)
endfunction()

function(deepslam_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow -Werror)
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    # Written for gcc's vectoriser: its pragmas, and conditions without branches.
    target_compile_options(${target} PRIVATE -Wno-unknown-pragmas -Wno-unknown-warning-option
                           -Wno-bitwise-instead-of-logical)
  endif()
  if(DEEPSLAM_ASAN)
    # Under ASan Eigen would choose another allocator than the packaged Ceres was built with, and memory that crosses
    # between them would be freed by the wrong one.
    target_compile_definitions(${target} PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
    target_compile_options(${target} PUBLIC -fsanitize=address -fno-omit-frame-pointer)
    # Instrumented code confuses gcc 12 about what is initialised.
    target_compile_options(${target} PRIVATE -Wno-error=maybe-uninitialized)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
    deepslam_run_path_for_all(${target})
    if(NOT ARGV1 STREQUAL "NO_UBSAN")
      target_compile_options(${target} PRIVATE -fsanitize=undefined -fno-sanitize-recover=undefined)
    endif()
  endif()
  if(DEEPSLAM_TSAN)
    target_compile_options(${target} PUBLIC -fsanitize=thread -fno-omit-frame-pointer)
    # Fences, which the headers of oneTBB have and ThreadSanitizer does not know.
    target_compile_options(${target} PRIVATE -Wno-tsan -Wno-error=maybe-uninitialized)
    target_link_options(${target} PUBLIC -fsanitize=thread)
    deepslam_run_path_for_all(${target})
  endif()
  if(DEEPSLAM_FUZZ)
    target_compile_definitions(${target} PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
                           -fno-omit-frame-pointer)
  endif()
endfunction()

option(DEEPSLAM_PCH "What most files include is compiled once, which takes a cold build half its time" ON)

# deepslam_compile_headers(<name> [HEADERS <header>...] [LINKS <target>...]): the headers of most files, and those given,
# compiled once, as users of these targets compile them, for all that ask for them. Every file still includes what it uses, as
# builds without this show (those with sanitizers).
function(deepslam_compile_headers name)
  cmake_parse_arguments(COMPILED "" "" "HEADERS;LINKS" ${ARGN})
  if(NOT DEEPSLAM_PCH OR DEEPSLAM_ASAN OR DEEPSLAM_TSAN OR DEEPSLAM_FUZZ)
    return()
  endif()
  file(WRITE "${PROJECT_BINARY_DIR}/${name}.cc" "")
  add_library(${name} OBJECT "${PROJECT_BINARY_DIR}/${name}.cc")
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PRIVATE Eigen3::Eigen fmt::fmt ${COMPILED_LINKS})
  deepslam_compile_options(${name})
  target_precompile_headers(${name} PRIVATE
    <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <functional> <map> <memory> <numbers> <optional> <set> <span> <string>
    <string_view> <utility> <vector> <Eigen/Core> <Eigen/Geometry> <fmt/format.h> ${COMPILED_HEADERS})
endfunction()
deepslam_compile_headers(deepslam_common_headers)
# Of code that hands things on and computes nothing: optimising it thoroughly takes longer than all that it will ever do.
add_library(deepslam_optimized_less INTERFACE)
target_compile_options(deepslam_optimized_less INTERFACE $<$<CONFIG:Release>:-O1>)
deepslam_compile_headers(deepslam_optimized_less_headers LINKS deepslam_optimized_less)

# deepslam_use_headers(<target> <name>): of deepslam_compile_headers.
function(deepslam_use_headers target name)
  if(NOT TARGET ${name})
    return()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${name})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL EXECUTABLE)  # code that can be moved as that of libraries is, since the headers were compiled for these
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC)
  endif()
  target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)  # as they were compiled
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # What compiler caches need to know is kept. And gcc 12 forgets that precompiled headers are the system's, and warns of what
    # it takes their inlined code for.
    target_compile_options(${target} PRIVATE -fpch-preprocess -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict
                           -Wno-array-bounds -Wno-maybe-uninitialized)
  endif()
endfunction()

# deepslam_link_fenced(<target> <third-party library>...): whose headers are not ours to warn about.
function(deepslam_link_fenced target)
  foreach(lib IN LISTS ARGN)
    target_link_libraries(${target} PRIVATE ${lib})
    if(TARGET ${lib})
      get_target_property(includes ${lib} INTERFACE_INCLUDE_DIRECTORIES)
      if(includes)
        target_include_directories(${target} SYSTEM PRIVATE ${includes})
      endif()
    endif()
  endforeach()
endfunction()

function(deepslam_module module)
  cmake_parse_arguments(MODULE "NO_UBSAN;OPTIMIZE_LESS;UNITY" "" "SOURCES;DEPS;FENCED" ${ARGN})
  set(target deepslam_${module})
  add_library(${target} STATIC ${MODULE_SOURCES})
  add_library(deepslam::${module} ALIAS ${target})
  target_include_directories(${target} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>")
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target} PUBLIC Eigen3::Eigen)
  foreach(dep IN LISTS MODULE_DEPS)
    target_link_libraries(${target} PUBLIC deepslam::${dep})
  endforeach()
  deepslam_link_fenced(${target} ${MODULE_FENCED})
  if(MODULE_NO_UBSAN)
    deepslam_compile_options(${target} NO_UBSAN)
  else()
    deepslam_compile_options(${target})
  endif()
  if(MODULE_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    # gcc excuses a class with members of a file's own types in the file that is compiled alone.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
  if(MODULE_OPTIMIZE_LESS)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:deepslam_optimized_less>)
    deepslam_use_headers(${target} deepslam_optimized_less_headers)
  else()
    deepslam_use_headers(${target} deepslam_common_headers)
  endif()
  deepslam_install_module(${module} DEPS ${MODULE_DEPS} FENCED ${MODULE_FENCED})
endfunction()

# deepslam_timeout(<seconds> <test>...): ends what hangs; sanitized builds have five times as long.
function(deepslam_timeout seconds)
  if(DEEPSLAM_ASAN OR DEEPSLAM_TSAN)
    math(EXPR seconds "5 * ${seconds}")
  endif()
  set_tests_properties(${ARGN} PROPERTIES TIMEOUT ${seconds})
endfunction()

# deepslam_test(<module> SOURCES a_test.cc ... DEPS modules... FENCED libs... [LABEL unit|real|kill|web] [TIMEOUT s])
# One test executable per module; tests are named as GoogleTest names them.
include(GoogleTest)
function(deepslam_test name)
  cmake_parse_arguments(TEST "" "LABEL;TIMEOUT" "SOURCES;DEPS;FENCED" ${ARGN})
  if(NOT TEST_LABEL)
    set(TEST_LABEL unit)
  endif()
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 900)  # ends what hangs; sanitized builds on a busy machine take minutes
  endif()
  set(target deepslam_${name}_test)
  add_executable(${target} ${TEST_SOURCES})
  foreach(dep IN LISTS TEST_DEPS)
    target_link_libraries(${target} PRIVATE deepslam::${dep})
  endforeach()
  target_link_libraries(${target} PRIVATE GTest::gmock GTest::gtest deepslam_test_main)
  deepslam_link_fenced(${target} ${TEST_FENCED})
  deepslam_compile_options(${target})
  deepslam_use_headers(${target} deepslam_test_headers)
  gtest_discover_tests(${target}
    DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${TEST_LABEL} TIMEOUT ${TEST_TIMEOUT})
endfunction()

// Real captures and meshes that are not in the repository: DEEPSLAM_TEST_DATA names their folder.
// Tests that need it start with DEEPSLAM_REQUIRE_TEST_DATA(dir); without the folder they report
// themselves skipped.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

#include <gtest/gtest.h>

namespace deepslam::testing_support {

inline std::optional<std::filesystem::path> TestData() {
  const char* dir = std::getenv("DEEPSLAM_TEST_DATA");
  if (dir == nullptr || !std::filesystem::is_directory(dir)) return std::nullopt;
  return std::filesystem::path(dir);
}

}  // namespace deepslam::testing_support

#define DEEPSLAM_REQUIRE_TEST_DATA(dir)                                      \
  const auto dir##_optional = ::deepslam::testing_support::TestData();       \
  if (!dir##_optional) GTEST_SKIP() << "DEEPSLAM_TEST_DATA names no folder"; \
  const std::filesystem::path dir = *dir##_optional

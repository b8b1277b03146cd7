// A capture that a test takes for readable; an empty one, and the test has failed, where it is not.
#pragma once

#include <filesystem>
#include <utility>

#include <gtest/gtest.h>

#include "deepslam/dataset/capture.h"

namespace deepslam::dataset {

inline Capture Open(const std::filesystem::path& path) {
  Result<Capture> capture = OpenCapture(path);
  EXPECT_TRUE(capture.ok()) << (capture.ok() ? "" : capture.error().message);
  return capture.ok() ? std::move(capture).value() : Capture();
}

}  // namespace deepslam::dataset

// A capture that a test takes for readable; an empty one, and the test has failed, where it is not.
#pragma once

#include <filesystem>
#include <utility>

#include <gtest/gtest.h>

#include "deepslam/layouts/open_capture.h"

namespace deepslam::layouts {

inline dataset::Capture Open(const std::filesystem::path& path) {
  Result<dataset::Capture> capture = OpenCapture(path);
  EXPECT_TRUE(capture.ok()) << (capture.ok() ? "" : capture.error().message);
  return capture.ok() ? std::move(capture).value() : dataset::Capture();
}

// Every second and third frame of it are those, whatever holds them.
inline void ExpectEveryNthIsItself(const dataset::Capture& capture) {
  const std::vector<dataset::StoredFrame>& all = capture.stored->frames();
  for (const std::size_t step : {std::size_t{2}, std::size_t{3}, all.size() + 1}) {
    const std::shared_ptr<const dataset::StoredFrames> some = capture.stored->Every(step);
    ASSERT_EQ(some->frames().size(), (all.size() + step - 1) / step);
    for (std::size_t i = 0; i < some->frames().size(); ++i) {
      const dataset::StoredFrame& own = some->frames()[i];
      EXPECT_EQ(own.depth_time_s, all[i * step].depth_time_s);
      EXPECT_EQ(own.colour_name, all[i * step].colour_name);
      EXPECT_EQ(own.world_from_colour, all[i * step].world_from_colour);
      const auto colour = some->ReadColour(i);
      const auto same_colour = capture.stored->ReadColour(i * step);
      ASSERT_TRUE(colour.ok() && same_colour.ok());
      EXPECT_EQ(colour->bytes, same_colour->bytes);
      EXPECT_EQ(colour->pixels, same_colour->pixels);
      EXPECT_EQ(*some->ReadDepth(i), *capture.stored->ReadDepth(i * step));
    }
  }
}

}  // namespace deepslam::layouts

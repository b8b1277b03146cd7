// Small captures on disk for the tests of this folder.
#pragma once

#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "deepslam/dataset/image_files.h"
#include "support/temp_dir.h"

namespace deepslam::layouts {

inline constexpr int kTestWidth = 32;
inline constexpr int kTestHeight = 24;

inline const char* const kTestSettings =
    "format: tum\ncamera: {width: 32, height: 24, fx: 30, fy: 30, cx: 15.5, cy: "
    "11.5}\ndepth_units_per_m: 1000\n";

// rgb/<i>.png of grey 10 i with a brighter middle, depth/<i>.png of 1000 + i.
inline void WriteImages(const std::filesystem::path& folder, int i) {
  std::filesystem::create_directories(folder / "rgb");
  std::filesystem::create_directories(folder / "depth");
  const auto grey = static_cast<std::uint8_t>(10 * i);
  const auto brighter = static_cast<std::uint8_t>(grey + 40);
  ColourImage colour(kTestWidth, kTestHeight, Rgb8{grey, grey, grey});
  for (int v = 0; v < kTestHeight; ++v)
    for (int u = kTestWidth / 4; u < kTestWidth / 2; ++u) colour(u, v) = {brighter, brighter, brighter};
  ASSERT_TRUE(dataset::WriteColourFile(folder / fmt::format("rgb/{}.png", i), colour).ok());
  ASSERT_TRUE(dataset::WriteDepthFile(
                  folder / fmt::format("depth/{}.png", i),
                  RawDepthImage(kTestWidth, kTestHeight, static_cast<std::uint16_t>(1000 + i)))
                  .ok());
}

// A whole capture of frames at 0.0, 0.1, 0.2 ... s with rgb.txt, depth.txt and capture.yaml.
inline void WriteCapture(const std::filesystem::path& folder, int num_frames) {
  std::string rgb = "# timestamp filename\n";
  std::string depth = rgb;
  for (int i = 0; i < num_frames; ++i) {
    WriteImages(folder, i);
    rgb += fmt::format("{:.6f} rgb/{}.png\n", 0.1 * i, i);
    depth += fmt::format("{:.6f} depth/{}.png\n", 0.1 * i, i);
  }
  testing_support::WriteText(folder / "rgb.txt", rgb);
  testing_support::WriteText(folder / "depth.txt", depth);
  testing_support::WriteText(folder / "capture.yaml", kTestSettings);
}

}  // namespace deepslam::layouts

// Captures in the layouts of recorders and data sets, each written by its own description with code
// of the tests alone: pixels, poses and intrinsics are foreign_captures.h's.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace deepslam::layouts::foreign {

inline constexpr int kWrittenFrames = 4;

struct WrittenLayout {
  std::string name;  // as the program calls it
  std::function<void(const std::filesystem::path&)> write;
  std::vector<std::string> texts;  // files that are parsed, relative to the capture
  double time_step_s = 1.0 / 30;
  bool real_depth = false;  // m as numbers with a point
};
inline void PrintTo(const WrittenLayout& layout, std::ostream* out) { *out << layout.name; }

[[nodiscard]] std::vector<WrittenLayout> WrittenLayouts();

// A pose as its matrix row by row, with the axes of OpenGL's camera (y up, z back).
[[nodiscard]] std::string OpenGlRows(int i, const std::string& open, const std::string& close);

// A database as RTAB-Map keeps it.
void WriteDatabase(const std::filesystem::path& file, int num_nodes);

// Images of frame i as files of several kinds.
[[nodiscard]] std::string PgmDepth(int i);
[[nodiscard]] std::string NpyDepth(int i);   // float32, m
[[nodiscard]] std::string ExrDepth(int i);   // m
[[nodiscard]] std::string TiffDepth(int i);  // 16 bits, mm

}  // namespace deepslam::layouts::foreign

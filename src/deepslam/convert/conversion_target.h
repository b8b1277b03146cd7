// Where a conversion's result comes to lie.
#pragma once

#include <filesystem>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/core/result.h"

namespace deepslam::convert {

// A path of its own beside the result, removed unless the result stands.
class Aside {
 public:
  explicit Aside(std::filesystem::path to);
  ~Aside() { Remove(); }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // Puts it in the result's place.
  [[nodiscard]] Status Commit();

 private:
  void Remove();

  std::filesystem::path to_;
  std::filesystem::path path_;
};

// Refuses (kInvalidConfig) what exists, an empty folder apart, and names that are not the format's.
[[nodiscard]] Status CheckTarget(const std::filesystem::path& to, const OutputFormat& format);

}  // namespace deepslam::convert

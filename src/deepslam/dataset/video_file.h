// A video read frame by frame. Frames come in the order in which they lie in the file; asking for
// an earlier one starts over, so ask in ascending order.
#pragma once

#include <filesystem>
#include <memory>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam::dataset {

class VideoFile {
 public:
  static Result<std::unique_ptr<VideoFile>> Open(const std::filesystem::path& file);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  [[nodiscard]] const std::filesystem::path& file() const;
  // As the file's own index says; 0 where it says nothing.
  [[nodiscard]] int num_frames() const;
  [[nodiscard]] int width() const;   // px, as stored: rotation tags are ignored
  [[nodiscard]] int height() const;  // px

  // Thread-safe; a few frames before the last one are kept, so that threads that work on
  // neighbouring frames may ask in any order.
  [[nodiscard]] Result<ColourImage> Read(int index);

 private:
  struct Impl;
  explicit VideoFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::dataset

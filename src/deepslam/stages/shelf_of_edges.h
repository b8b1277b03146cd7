// Measurements of a path in a scratch file: they grow by a kilobyte a frame, and nobody needs more
// than a few of them at a time.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/storage/scratch_file.h"

namespace deepslam::stages {

class ShelfOfEdges final : public ShelvedEdges {
 public:
  explicit ShelfOfEdges(std::shared_ptr<storage::ScratchFile> file);
  ~ShelfOfEdges() override;

  // Behind those that are there. Not beside anybody who reads.
  [[nodiscard]] Status Add(const RelativePose& edge);
  [[nodiscard]] Status Add(std::span<const RelativePose> edges);

  [[nodiscard]] std::size_t size() const override { return num_in_file_ + last_.size(); }
  void Read(std::size_t first, std::span<RelativePose> edges) const override;

 private:
  std::shared_ptr<storage::ScratchFile> file_;
  std::size_t num_in_file_ = 0;
  std::vector<RelativePose> last_;  // on their way there
};

}  // namespace deepslam::stages

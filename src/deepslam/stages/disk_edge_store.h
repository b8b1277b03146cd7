// Measurements of a path out of core, in a scratch file: they grow by a kilobyte a frame, and
// nobody needs more than a few of them at a time. What the machine does not give back is an edge of
// no frames, and the file remembers the fault.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/edge_store.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/storage/scratch_file.h"

namespace deepslam::stages {

class DiskEdgeStore final : public EdgeStore {
 public:
  explicit DiskEdgeStore(std::shared_ptr<storage::ScratchFile> file);
  ~DiskEdgeStore() override;

  [[nodiscard]] Status Add(const RelativePose& edge) override;
  [[nodiscard]] std::size_t size() const override { return num_in_file_ + last_.size(); }
  void Read(std::size_t first, std::span<RelativePose> edges) const override;

 private:
  std::shared_ptr<storage::ScratchFile> file_;
  std::size_t num_in_file_ = 0;
  std::vector<RelativePose> last_;  // on their way there
};

// Stores in scratch files of the stage.
[[nodiscard]] EdgeStoreFactory DiskEdgeStores(const pipeline::StageContext& context);

}  // namespace deepslam::stages

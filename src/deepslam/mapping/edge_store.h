// Measurements of a path that grow by a kilobyte a frame: kept where the caller says, in memory or
// out of core.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

class EdgeStore : public ShelvedEdges {
 public:
  // Behind those that are there. Not while another thread adds or reads. An error is the machine's,
  // which has no more room.
  [[nodiscard]] virtual Status Add(const RelativePose& edge) = 0;
};

// A new, empty one for each call.
using EdgeStoreFactory = std::function<std::shared_ptr<EdgeStore>()>;

// One after the other; the first error ends it.
[[nodiscard]] Status AddAll(std::span<const RelativePose> edges, EdgeStore& store);

// For paths that are known to be short.
class MemoryEdgeStore final : public EdgeStore {
 public:
  [[nodiscard]] Status Add(const RelativePose& edge) override;
  [[nodiscard]] std::size_t size() const override { return edges_.size(); }
  void Read(std::size_t first, std::span<RelativePose> edges) const override;

 private:
  std::vector<RelativePose> edges_;
};

}  // namespace deepslam::mapping

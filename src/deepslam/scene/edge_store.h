// Measurements of a path that grow by a kilobyte a frame: kept where the caller says, in memory or
// out of core, and read a few at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam {

class EdgeStore {
 public:
  virtual ~EdgeStore() = default;
  // Behind those that are there. Not while another thread adds or reads. An error is the machine's,
  // which has no more room.
  [[nodiscard]] virtual Status Add(const RelativePose& edge) = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  // Those from `first` on, as many as there is place for. Thread-safe. One that the machine does
  // not give back joins no frames (its ids are not valid), and whoever keeps the store knows of it.
  virtual void Read(std::size_t first, std::span<RelativePose> edges) const = 0;
};

// A new, empty one for each call.
using EdgeStoreFactory = std::function<std::shared_ptr<EdgeStore>()>;

// One after the other; the first error ends it.
[[nodiscard]] Status AddAll(std::span<const RelativePose> edges, EdgeStore& store);

// One after the other, in their order.
void ForEach(const EdgeStore& edges, const std::function<void(const RelativePose&)>& use);

// For paths that are known to be short.
class MemoryEdgeStore final : public EdgeStore {
 public:
  [[nodiscard]] Status Add(const RelativePose& edge) override;
  [[nodiscard]] std::size_t size() const override { return edges_.size(); }
  void Read(std::size_t first, std::span<RelativePose> edges) const override;

 private:
  std::vector<RelativePose> edges_;
};

}  // namespace deepslam

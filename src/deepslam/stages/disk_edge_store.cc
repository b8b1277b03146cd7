#include "deepslam/stages/disk_edge_store.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "deepslam/core/check.h"

namespace deepslam::stages {
namespace {

constexpr std::size_t kAtOnce = 256;  // 64 KB

// An edge as it lies in the file. Frames count from 1, so that bytes the machine did not give,
// zeros, are no frame's.
struct Stored {
  std::array<double, 7> pose;  // x y z, qx qy qz qw
  SymmetricMatrix6d::Upper information;
  std::int32_t i, j;
  std::int64_t composed;
};

Stored ToStored(const RelativePose& edge) {
  const Eigen::Vector3d& t = edge.i_from_j.translation_m;
  const Eigen::Vector4d& q = edge.i_from_j.rotation.coeffs();
  return {{t[0], t[1], t[2], q[0], q[1], q[2], q[3]},
          edge.information.upper(),
          edge.i.value + 1,
          edge.j.value + 1,
          edge.composed ? 1 : 0};
}

RelativePose FromStored(const Stored& stored) {
  const auto& [x, y, z, qx, qy, qz, qw] = stored.pose;
  return {FrameIdx{stored.i - 1},
          FrameIdx{stored.j - 1},
          {Eigen::Quaterniond(qw, qx, qy, qz), {x, y, z}},
          SymmetricMatrix6d(stored.information),
          stored.composed != 0};
}

}  // namespace

DiskEdgeStore::DiskEdgeStore(std::shared_ptr<storage::ScratchFile> file) : file_(std::move(file)) {}
DiskEdgeStore::~DiskEdgeStore() = default;

Status DiskEdgeStore::Add(const RelativePose& edge) {
  last_.push_back(edge);
  if (last_.size() < kAtOnce) return Ok();
  std::vector<Stored> stored(last_.size());
  std::ranges::transform(last_, stored.begin(), ToStored);
  if (Status status = file_->Append(std::as_bytes(std::span(stored))); !status.ok()) return status;
  num_in_file_ += last_.size();
  last_.clear();
  return Ok();
}

void DiskEdgeStore::Read(std::size_t first, std::span<RelativePose> edges) const {
  DEEPSLAM_CHECK(first + edges.size() <= size(), "edges that are there");
  const std::size_t from_file =
      std::min(edges.size(), num_in_file_ - std::min(first, num_in_file_));
  std::vector<Stored> stored(from_file);
  file_->Read(first * sizeof(Stored), std::as_writable_bytes(std::span(stored)));
  std::ranges::transform(stored, edges.begin(), FromStored);
  for (std::size_t n = from_file; n < edges.size(); ++n) edges[n] = last_[first + n - num_in_file_];
}

EdgeStoreFactory DiskEdgeStores(const pipeline::StageContext& context) {
  return [&context] { return std::make_shared<DiskEdgeStore>(context.Scratch()); };
}

}  // namespace deepslam::stages

#include "known_shapes.h"

#include <algorithm>
#include <iterator>

#include "deepslam/core/sha256.h"

namespace deepslam::tools {

namespace {

// One in so many designs checks the training instead of taking part.
constexpr unsigned kValidateEvery = 12;

}  // namespace

void KnownShapes::Add(const VoxelGrid& shape) { shapes_.push_back(std::make_unique<Known>(shape)); }

std::optional<std::size_t> KnownShapes::FindAlike(const VoxelGrid& shape) const {
  if (shapes_.empty()) return std::nullopt;
  const library::ComparableShape comparable(shape);
  const auto found = std::find_if(shapes_.begin(), shapes_.end(), [&](const auto& known) {
    return Alike(known->comparable, comparable);
  });
  if (found == shapes_.end()) return std::nullopt;
  return static_cast<std::size_t>(std::distance(shapes_.begin(), found));
}

std::string ShapeGroups::SplitFor(const std::string& id, const VoxelGrid& shape) {
  if (const std::optional<std::size_t> like = shapes_.FindAlike(shape)) return splits_[*like];
  shapes_.Add(shape);
  splits_.push_back(SplitOf(id));
  return splits_.back();
}

std::string SplitOf(const std::string& id) {
  const std::string hash = Sha256Hex(id);
  const unsigned number = static_cast<unsigned>(std::stoul(hash.substr(0, 7), nullptr, 16));
  return number % kValidateEvery == 0 ? "validate" : "train";
}

}  // namespace deepslam::tools

// Strong identifiers, so that a frame cannot be passed as an object. `_idx` is dense and
// zero-based, `_id` sparse.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <ostream>

namespace deepslam {

template <typename Tag>
struct StrongId {
  std::int32_t value = -1;  // -1: none

  [[nodiscard]] constexpr bool valid() const { return value >= 0; }
  friend constexpr auto operator<=>(const StrongId&, const StrongId&) = default;
  friend std::ostream& operator<<(std::ostream& out, const StrongId& id) { return out << id.value; }
};

using FrameIdx = StrongId<struct FrameTag>;         // position in the capture's frame list
using DetectionId = StrongId<struct DetectionTag>;  // unique over the whole capture
using ObjectId = StrongId<struct ObjectTag>;  // unique over the whole capture, kept by merging
using CandidateId = StrongId<struct CandidateTag>;  // unique over the whole capture

}  // namespace deepslam

template <typename Tag>
struct std::hash<deepslam::StrongId<Tag>> {
  std::size_t operator()(const deepslam::StrongId<Tag>& id) const noexcept {
    return std::hash<std::int32_t>()(id.value);
  }
};

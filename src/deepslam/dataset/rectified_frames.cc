#include "deepslam/dataset/rectified_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "deepslam/core/every_nth.h"
#include "deepslam/dataset/surface_depth.h"

namespace deepslam::dataset {
namespace {

// Cameras that differ by less anywhere in the image are one: a tenth of a pixel is what detection
// of corners resolves.
constexpr double kSameCameraPx = 0.1;
constexpr float kNowhere = -1;  // no column or row is negative

// Where each pixel of a pinhole's image lies in the image that was taken, px; kNowhere outside it.
struct SourcePixel {
  float u = kNowhere;
  float v = kNowhere;
};
using Map = Image<SourcePixel>;

Map MakeMap(const PinholeCamera& target,
            const PinholeCamera& taken,
            const std::optional<LensDistortion>& lens) {
  Map map(target.width, target.height);
  const double largest = lens ? lens->LargestRadius() : 0;
  for (int v = 0; v < target.height; ++v) {
    for (int u = 0; u < target.width; ++u) {
      Eigen::Vector2d at = target.Ray(u, v).head<2>();
      if (lens && at.norm() > largest) continue;
      if (lens) at = lens->Distort(at);
      const double taken_u = taken.fx * at.x() + taken.cx;
      const double taken_v = taken.fy * at.y() + taken.cy;
      if (!(taken_u >= -kSameCameraPx && taken_u <= taken.width - 1 + kSameCameraPx &&
            taken_v >= -kSameCameraPx && taken_v <= taken.height - 1 + kSameCameraPx)) {
        continue;
      }
      map(u, v) = {static_cast<float>(std::clamp(taken_u, 0.0, taken.width - 1.0)),
                   static_cast<float>(std::clamp(taken_v, 0.0, taken.height - 1.0))};
    }
  }
  return map;
}

// The neighbours of a place and the shares of the later ones.
struct Neighbours {
  int u, v, next_u, next_v;
  double share_u, share_v;
};

Neighbours NeighboursOf(const SourcePixel& place, int width, int height) {
  const int u = static_cast<int>(place.u);
  const int v = static_cast<int>(place.v);
  return {u,
          v,
          std::min(u + 1, width - 1),
          std::min(v + 1, height - 1),
          static_cast<double>(place.u) - u,
          static_cast<double>(place.v) - v};
}

ColourImage Through(const Map& map, const ColourImage& taken) {
  ColourImage out(map.width(), map.height());
  std::transform(map.begin(), map.end(), out.begin(), [&](const SourcePixel& place) {
    if (place.u < 0) return Rgb8{};
    const Neighbours n = NeighboursOf(place, taken.width(), taken.height());
    const auto mixed = [&](std::uint8_t Rgb8::*channel) {
      const double upper = (1 - n.share_u) * (taken(n.u, n.v).*channel) +
                           n.share_u * (taken(n.next_u, n.v).*channel);
      const double lower = (1 - n.share_u) * (taken(n.u, n.next_v).*channel) +
                           n.share_u * (taken(n.next_u, n.next_v).*channel);
      return static_cast<std::uint8_t>(std::lround((1 - n.share_v) * upper + n.share_v * lower));
    };
    return Rgb8{mixed(&Rgb8::r), mixed(&Rgb8::g), mixed(&Rgb8::b)};
  });
  return out;
}

// Raw depth is proportional to depth, but for the value that stands for nothing measured.
RawDepthImage Through(const Map& map, const RawDepthImage& taken, float max_ratio) {
  RawDepthImage out(map.width(), map.height());
  const auto raw = [&](int u, int v) {
    const std::uint16_t value = taken(u, v);
    return value == kSaturatedDepth ? 0.0F : static_cast<float>(value);
  };
  std::transform(map.begin(), map.end(), out.begin(), [&](const SourcePixel& place) {
    if (place.u < 0) return kNoDepth;
    const Neighbours n = NeighboursOf(place, taken.width(), taken.height());
    const std::array<float, 4> around = {
        raw(n.u, n.v), raw(n.next_u, n.v), raw(n.u, n.next_v), raw(n.next_u, n.next_v)};
    if (OneSurface(around, max_ratio)) {
      return static_cast<std::uint16_t>(std::lround(BetweenOnPlane(around, n.share_u, n.share_v)));
    }
    return static_cast<std::uint16_t>(
        around[(n.share_u < 0.5 ? 0U : 1U) + (n.share_v < 0.5 ? 0U : 2U)]);
  });
  return out;
}

bool Alike(const PinholeCamera& a, const PinholeCamera& b) {
  if (a.width != b.width || a.height != b.height) return false;
  for (const double u : {0.0, a.width - 1.0}) {
    for (const double v : {0.0, a.height - 1.0}) {
      const auto moved = b.Project(a.Ray(u, v));
      if (!moved || (*moved - Eigen::Vector2d(u, v)).norm() > kSameCameraPx) return false;
    }
  }
  return true;
}

// One of the two images of each frame.
struct Path {
  PinholeCamera target;
  std::optional<LensDistortion> lens;
  std::vector<PinholeCamera> cameras;  // per frame; empty: target
  std::shared_ptr<const Map> map;      // of all frames, unless there are `cameras`

  // Nothing where frame i passes as it is.
  [[nodiscard]] std::shared_ptr<const Map> MapOf(std::size_t i) const {
    if (cameras.empty()) return map;
    if (!lens && Alike(cameras[i], target)) return nullptr;
    return std::make_shared<const Map>(MakeMap(target, cameras[i], lens));
  }
};

Path MakePath(const PinholeCamera& target,
              const std::optional<LensDistortion>& lens,
              std::vector<PinholeCamera> cameras) {
  Path path{target, lens, std::move(cameras), nullptr};
  if (lens && path.cameras.empty())
    path.map = std::make_shared<const Map>(MakeMap(target, target, lens));
  return path;
}

class RectifiedFrames final : public StoredFrames {
 public:
  RectifiedFrames(std::shared_ptr<const StoredFrames> taken, Path colour, Path depth)
      : StoredFrames(taken->cameras(), taken->frames()),
        taken_(std::move(taken)),
        colour_(std::move(colour)),
        depth_(std::move(depth)),
        max_ratio_(MaxDepthRatio(depth_.target)) {}

  [[nodiscard]] Result<StoredColour> ReadColour(std::size_t i) const override {
    Result<StoredColour> stored = taken_->ReadColour(i);
    const std::shared_ptr<const Map> map = colour_.MapOf(i);
    if (!stored || map == nullptr) return stored;
    std::string name = stored->name;
    const Result<ColourImage> pixels = DecodeStored(*std::move(stored), cameras().colour);
    if (!pixels) return pixels.error();
    return StoredColour{ImageCodec::kOther, {}, Through(*map, *pixels), std::move(name)};
  }

  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    Result<RawDepthImage> raw = taken_->ReadDepth(i);
    const std::shared_ptr<const Map> map = depth_.MapOf(i);
    if (!raw || map == nullptr) return raw;
    return Through(*map, *raw, max_ratio_);
  }

  [[nodiscard]] bool colour_in_order() const override { return taken_->colour_in_order(); }

  [[nodiscard]] std::shared_ptr<const StoredFrames> Every(std::size_t step) const override {
    Path colour = colour_;
    Path depth = depth_;
    if (!colour.cameras.empty()) colour.cameras = EveryNth(colour.cameras, step);
    if (!depth.cameras.empty()) depth.cameras = EveryNth(depth.cameras, step);
    return std::make_shared<RectifiedFrames>(
        taken_->Every(step), std::move(colour), std::move(depth));
  }

 private:
  std::shared_ptr<const StoredFrames> taken_;
  Path colour_;
  Path depth_;
  float max_ratio_;
};

}  // namespace

std::shared_ptr<const StoredFrames> RectifyFrames(std::shared_ptr<const StoredFrames> frames,
                                                  Optics optics) {
  const CaptureCameras& cameras = frames->cameras();
  const auto same = [](const std::vector<PinholeCamera>& all, const PinholeCamera& common) {
    return std::all_of(all.begin(), all.end(), [&](const auto& own) { return Alike(own, common); });
  };
  if (same(optics.colour_cameras, cameras.colour)) optics.colour_cameras.clear();
  if (same(optics.depth_cameras, cameras.depth)) optics.depth_cameras.clear();
  if (optics.colour && optics.colour->IsNone()) optics.colour.reset();
  if (optics.depth && optics.depth->IsNone()) optics.depth.reset();
  if (optics.is_pinhole()) return frames;
  Path colour = MakePath(cameras.colour, optics.colour, std::move(optics.colour_cameras));
  Path depth = MakePath(cameras.depth, optics.depth, std::move(optics.depth_cameras));
  return std::make_shared<RectifiedFrames>(std::move(frames), std::move(colour), std::move(depth));
}

}  // namespace deepslam::dataset

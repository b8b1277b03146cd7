#include "deepslam/segment/image_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/segment/smooth_links.h"

namespace deepslam::segment {
namespace {

constexpr std::size_t kRowsPerChunk = 16;  // of one task; results are the same for any
constexpr double kFarthest_m = 1000;  // only absurd intrinsics put points farther out
constexpr int kMinPiece_px = 12;      // pieces of fewer pixels are noise
constexpr std::int32_t kNone = -1;    // of no part, or of no piece

// Where usable points lie: up to a depth, and above the ground's noise.
struct Usable {
  double max_depth_m = 0;
  std::array<double, 3> up{};
  double d_m = 0;
  double min_height_m = 0;
  double height_per_m2 = 0;
};

Usable UsableAbove(const std::optional<Plane>& ground_camera, const SegmentOptions& options) {
  constexpr double kAnyHeight = -std::numeric_limits<double>::infinity();
  if (!ground_camera) return {options.max_depth_m, {}, 0, kAnyHeight, 0};
  const Eigen::Vector3d& up = ground_camera->normal;
  return {options.max_depth_m,
          {up.x(), up.y(), up.z()},
          ground_camera->d_m,
          SegmentOptions::kMinHeight_m,
          SegmentOptions::kHeight_per_m2};
}

struct PointRow {
  float* x_m;
  float* y_m;
  float* z_m;
  float* height_m;
  std::uint8_t* beyond;
};

DEEPSLAM_WIDE_VECTORS void UnprojectRow(const float* depth_m,
                                        const double* rays_x,
                                        double ray_y,
                                        int width,
                                        const Usable& usable,
                                        const PointRow& row) {
  const auto [x_m, y_m, z_m, height_m, beyond] = row;
  const Usable in = usable;
#pragma GCC ivdep
  for (int u = 0; u < width; ++u) {
    const double z = depth_m[u];
    const double x = z * rays_x[u];
    const double y = z * ray_y;
    const double height = (in.up[0] * x + in.up[1] * y) + in.up[2] * z + in.d_m;
    const bool measured = z > 0;
    const bool in_reach = measured & (z <= in.max_depth_m) & (std::abs(x) < kFarthest_m) &
                          (std::abs(y) < kFarthest_m) & (z < kFarthest_m);
    const bool kept = in_reach & (height >= in.min_height_m + in.height_per_m2 * z * z);
    x_m[u] = kept ? static_cast<float>(x) : 0.0F;
    y_m[u] = kept ? static_cast<float>(y) : 0.0F;
    z_m[u] = kept ? static_cast<float>(z) : 0.0F;
    height_m[u] = in_reach ? static_cast<float>(height) : 0.0F;
    beyond[u] = (measured & !kept) ? 1 : 0;
  }
}

void FindUsablePoints(const DepthImage& depth_m,
                      const PinholeCamera& camera,
                      const std::optional<Plane>& ground_camera,
                      const SegmentOptions& options,
                      ImagePieces& pieces) {
  const int width = depth_m.width();
  std::vector<double> rays_x(static_cast<std::size_t>(width));
  for (int u = 0; u < width; ++u) rays_x[static_cast<std::size_t>(u)] = camera.Ray(u, 0).x();
  const Usable usable = UsableAbove(ground_camera, options);
  PointImage& points = pieces.points_camera;
  ParallelForChunks(static_cast<std::size_t>(depth_m.height()),
                    kRowsPerChunk,
                    [&](std::size_t begin, std::size_t end) {
                      for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                        UnprojectRow(depth_m.row(v),
                                     rays_x.data(),
                                     camera.Ray(0, v).y(),
                                     width,
                                     usable,
                                     {points.x_row(v),
                                      points.y_row(v),
                                      points.z_row(v),
                                      pieces.height_m.row(v),
                                      pieces.beyond.row(v)});
                      }
                    });
}

// Pixels joined in both directions, as parts that grow while the image is read row by row.
class Parts {
 public:
  std::int32_t Add() {
    parents_.push_back(static_cast<std::int32_t>(parents_.size()));
    num_pixels_.push_back(0);
    return parents_.back();
  }
  void Count(std::int32_t part, int num_pixels) { num_pixels_[Idx(part)] += num_pixels; }
  // The part with the lower number stands for both: its pixels came first.
  void Join(std::int32_t a, std::int32_t b) {
    a = Root(a);
    b = Root(b);
    parents_[Idx(std::max(a, b))] = std::min(a, b);
  }
  [[nodiscard]] std::int32_t Root(std::int32_t part) {
    while (parents_[Idx(part)] != part) {
      parents_[Idx(part)] = parents_[Idx(parents_[Idx(part)])];
      part = parents_[Idx(part)];
    }
    return part;
  }
  [[nodiscard]] std::int32_t size() const { return static_cast<std::int32_t>(parents_.size()); }
  [[nodiscard]] int num_pixels(std::int32_t part) const { return num_pixels_[Idx(part)]; }

 private:
  static std::size_t Idx(std::int32_t part) { return static_cast<std::size_t>(part); }

  std::vector<std::int32_t> parents_;
  std::vector<int> num_pixels_;
};

using Arc = std::pair<std::int32_t, std::int32_t>;

// Numbers of parts to `part`, kNone without a normal; `arcs`: between pixels joined in one
// direction.
void NumberParts(const Mask& bits,
                 Image<std::int32_t>& part,
                 Parts& parts,
                 std::vector<Arc>& arcs) {
  constexpr int kLeft = kFromLeft | kToLeft;
  constexpr int kAbove = kFromAbove | kToAbove;
  for (int v = 0; v < bits.height(); ++v) {
    const std::uint8_t* const links = bits.row(v);
    std::int32_t* const row = part.row(v);
    const std::int32_t* const row_above = v > 0 ? part.row(v - 1) : nullptr;
    std::int32_t current = kNone;
    int begin = 0;  // of the pixels of the current part
    const auto end_run = [&](int u) {
      if (current != kNone) parts.Count(current, u - begin);
      begin = u;
    };
    for (int u = 0; u < bits.width(); ++u) {
      const int link = links[u];
      const int left = link & kLeft;
      const int above = link & kAbove;
      if (left != kLeft) {
        end_run(u);
        if ((link & kHasNormal) == 0) {
          current = kNone;
        } else {
          current = above == kAbove ? row_above[u] : parts.Add();
        }
      } else if (above == kAbove && row_above[u] != current) {
        parts.Join(current, row_above[u]);
        end_run(u);
        current = row_above[u];
      }
      row[u] = current;
      if (left == kFromLeft) arcs.emplace_back(row[u - 1], current);
      if (left == kToLeft) arcs.emplace_back(current, row[u - 1]);
      if (above == kFromAbove) arcs.emplace_back(row_above[u], current);
      if (above == kToAbove) arcs.emplace_back(current, row_above[u]);
    }
    end_run(bits.width());
  }
}

// Parts grow to pieces along arcs, in the order of their first pixels: the piece of every root.
std::vector<std::int32_t> PiecesOfParts(Parts& parts, std::vector<Arc>& arcs, int& num_pieces) {
  for (Arc& arc : arcs) arc = {parts.Root(arc.first), parts.Root(arc.second)};
  std::sort(arcs.begin(), arcs.end());
  std::vector<std::int32_t> piece_of(static_cast<std::size_t>(parts.size()), kNone);
  std::vector<std::int32_t> open;
  num_pieces = 0;
  for (std::int32_t seed = 0; seed < parts.size(); ++seed) {
    if (parts.Root(seed) != seed || piece_of[static_cast<std::size_t>(seed)] != kNone) continue;
    const int piece = num_pieces++;
    piece_of[static_cast<std::size_t>(seed)] = piece;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::int32_t at = open.back();
      open.pop_back();
      for (auto arc = std::lower_bound(arcs.begin(), arcs.end(), Arc{at, kNone});
           arc != arcs.end() && arc->first == at;
           ++arc) {
        std::int32_t& to = piece_of[static_cast<std::size_t>(arc->second)];
        if (to != kNone) continue;
        to = piece;
        open.push_back(arc->second);
      }
    }
  }
  return piece_of;
}

// Grows smooth pieces over pixels with normals, in image order; small components are left out.
void GrowPieces(const Mask& bits, ImagePieces& pieces) {
  Parts parts;
  std::vector<Arc> arcs;
  NumberParts(bits, pieces.piece, parts, arcs);
  int num_grown = 0;
  std::vector<std::int32_t> piece_of = PiecesOfParts(parts, arcs, num_grown);
  std::vector<int> num_pixels(static_cast<std::size_t>(num_grown));
  for (std::int32_t part = 0; part < parts.size(); ++part) {
    std::int32_t& piece = piece_of[static_cast<std::size_t>(part)];
    piece = piece_of[static_cast<std::size_t>(parts.Root(part))];
    num_pixels[static_cast<std::size_t>(piece)] += parts.num_pixels(part);
  }
  std::vector<std::int32_t> number(num_pixels.size(), kNone);
  for (std::size_t n = 0; n < num_pixels.size(); ++n) {
    if (num_pixels[n] < kMinPiece_px) continue;
    number[n] = static_cast<std::int32_t>(pieces.num_pixels.size());
    pieces.num_pixels.push_back(num_pixels[n]);
  }
  for (std::int32_t& piece : piece_of) piece = number[static_cast<std::size_t>(piece)];
  for (std::int32_t& piece : pieces.piece) {
    if (piece != kNone) piece = piece_of[static_cast<std::size_t>(piece)];
  }
}

struct Pixel {
  int u, v;
};

constexpr std::array<Pixel, 4> kSteps = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

// Pixels with a point that no piece holds, and those of pieces beside them.
class Fringe {
 public:
  explicit Fringe(const ImagePieces& pieces)
      : pieces_(&pieces),
        width_(pieces.piece.width()),
        above_(Size()),
        row_(Size()),
        below_(Size()),
        beside_(Size()) {
    MarkFree(0, below_);
  }

  // Appends the pixels of pieces in row v that have a free neighbour. To be called row by row.
  void Append(int v, std::vector<Pixel>& pixels) {
    std::swap(above_, row_);
    std::swap(row_, below_);
    MarkFree(v + 1, below_);
    FindBeside(v);
    for (int u = 0; u < width_; ++u) {
      if (beside_[static_cast<std::size_t>(u)] != 0) pixels.push_back({u, v});
    }
  }

 private:
  using Flags = std::vector<std::int32_t>;  // one per pixel, from 1 on

  [[nodiscard]] std::size_t Size() const { return static_cast<std::size_t>(width_) + 2; }
  void MarkFree(int v, Flags& free) const;
  void FindBeside(int v);

  const ImagePieces* pieces_;
  int width_;
  Flags above_, row_, below_;
  Flags beside_;
};

DEEPSLAM_WIDE_VECTORS void Fringe::MarkFree(int v, Flags& free) const {
  if (v >= pieces_->piece.height()) {
    std::fill(free.begin(), free.end(), 0);
    return;
  }
  const float* const z_m = pieces_->points_camera.z_row(v);
  const std::int32_t* const piece = pieces_->piece.row(v);
  std::int32_t* const flags = free.data() + 1;
  const int width = width_;
#pragma GCC ivdep
  for (int u = 0; u < width; ++u) flags[u] = ((z_m[u] > 0) & (piece[u] < 0)) ? 1 : 0;
}

DEEPSLAM_WIDE_VECTORS void Fringe::FindBeside(int v) {
  const std::int32_t* const piece = pieces_->piece.row(v);
  const std::int32_t* const above = above_.data() + 1;
  const std::int32_t* const row = row_.data() + 1;
  const std::int32_t* const below = below_.data() + 1;
  std::int32_t* const beside = beside_.data();
  const int width = width_;
#pragma GCC ivdep
  for (int u = 0; u < width; ++u) {
    const std::int32_t free = row[u - 1] | row[u + 1] | above[u] | below[u];
    beside[u] = piece[u] >= 0 ? free : 0;
  }
}

// Grows pieces from the pixels in `open` from `head` on, first come first served, over free pixels
// next to them in depth; these join `open`.
void GrowInDepth(std::size_t head, std::vector<Pixel>& open, ImagePieces& pieces) {
  const PointImage& points = pieces.points_camera;
  for (; head < open.size(); ++head) {
    const Pixel at = open[head];
    const float z = points.z_m(at.u, at.v);
    const double jump = JumpAt(z);
    const std::int32_t id = pieces.piece(at.u, at.v);
    for (const Pixel& step : kSteps) {
      const Pixel to = {at.u + step.u, at.v + step.v};
      const float z_to = points.z_m(to.u, to.v);  // 0 outside the image
      if (!(z_to > 0) || pieces.piece(to.u, to.v) >= 0 || std::abs(z_to - z) >= jump) continue;
      pieces.piece(to.u, to.v) = id;
      ++pieces.num_pixels[static_cast<std::size_t>(id)];
      open.push_back(to);
    }
  }
}

// Gives pixels at edges, and those of small components, to the piece next to them in depth; what is
// left becomes pieces.
void AttachRest(ImagePieces& pieces) {
  const int height = pieces.piece.height();
  std::vector<Pixel> open;
  Fringe fringe(pieces);
  for (int v = 0; v < height; ++v) fringe.Append(v, open);
  GrowInDepth(0, open, pieces);
  for (int v = 0; v < height; ++v) {
    const float* const z_m = pieces.points_camera.z_row(v);
    const std::int32_t* const piece = pieces.piece.row(v);
    for (int u = 0; u < pieces.piece.width(); ++u) {
      if (piece[u] >= 0 || !(z_m[u] > 0)) continue;
      pieces.piece(u, v) = static_cast<std::int32_t>(pieces.num_pixels.size());
      pieces.num_pixels.push_back(1);
      open.assign(1, {u, v});
      GrowInDepth(0, open, pieces);
      // Specks are mixed pixels between foreground and background.
      if (open.size() >= kMinPiece_px) continue;
      for (const Pixel& pixel : open) {
        pieces.points_camera.Clear(pixel.u, pixel.v);
        pieces.piece(pixel.u, pixel.v) = kNone;
      }
      pieces.num_pixels.pop_back();
    }
  }
}

}  // namespace

ImagePieces CutIntoPieces(const DepthImage& depth_m,
                          const PinholeCamera& camera,
                          const std::optional<Plane>& ground_camera,
                          const SegmentOptions& options) {
  ImagePieces pieces;
  const int width = depth_m.width();
  const int height = depth_m.height();
  pieces.has_ground = ground_camera.has_value();
  pieces.height_m = Image<float>(width, height);
  pieces.beyond = Mask(width, height);
  pieces.points_camera = PointImage(width, height);
  FindUsablePoints(depth_m, camera, ground_camera, options, pieces);
  SmoothLinks links = FindSmoothLinks(pieces.points_camera, camera.fx, ground_camera);
  pieces.horizontal = std::move(links.horizontal);
  pieces.piece = Image<std::int32_t>(width, height);
  GrowPieces(links.bits, pieces);
  AttachRest(pieces);
  return pieces;
}

}  // namespace deepslam::segment

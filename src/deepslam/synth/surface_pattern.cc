#include "deepslam/synth/surface_pattern.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deepslam/core/random.h"

namespace deepslam::synth {
namespace {

std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

// Uniform in [-1, 1] per lattice point.
double Lattice(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  const std::uint64_t h = Mix(seed * 0x9E3779B97F4A7C15ULL + 0x632BE59BD9B4E019ULL +
                              static_cast<std::uint64_t>(x) * 0xD1B54A32D192ED03ULL +
                              static_cast<std::uint64_t>(y) * 0xABC98388FB8FAC03ULL +
                              static_cast<std::uint64_t>(z) * 0x8CB92BA72F3D8DD7ULL);
  return static_cast<double>(h >> 11) * 0x1.0p-52 - 1.0;
}

// Below x; std::floor is a call on machines of the baseline instruction set.
std::int64_t Floor(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return static_cast<double>(whole) > x ? whole - 1 : whole;
}

double Fade(double t) { return t * t * (3 - 2 * t); }

double Noise2(const Eigen::Vector2d& p, double size_m, std::uint64_t seed) {
  const double px = p.x() / size_m;
  const double py = p.y() / size_m;
  const std::int64_t x = Floor(px);
  const std::int64_t y = Floor(py);
  const double r = Fade(px - static_cast<double>(x));
  const double s = Fade(py - static_cast<double>(y));
  const auto row = [&](std::int64_t j) {
    const double low = Lattice(x, j, 0, seed);
    return low + r * (Lattice(x + 1, j, 0, seed) - low);
  };
  const double low = row(y);
  return low + s * (row(y + 1) - low);
}

Eigen::Vector3f Scaled(const Eigen::Vector3f& colour, double factor) {
  return (colour * static_cast<float>(factor)).cwiseMax(0.0f).cwiseMin(1.0f);
}

Eigen::Vector3f WoodFloor(const Eigen::Vector2d& p, std::uint64_t seed) {
  constexpr double kBoardWidthM = 0.12;  // as of common floor boards, ...
  constexpr double kBoardLengthM = 1.1;  // ... which begin shifted from row to row
  constexpr double kBoardGapM = 0.0025;  // dark, about a pixel of a 640 px wide camera at 1.3 m
  const double row = std::floor(p.y() / kBoardWidthM);
  const double shifted =
      p.x() + 0.5 * kBoardLengthM * Lattice(static_cast<std::int64_t>(row), 7, 7, seed);
  const double column = std::floor(shifted / kBoardLengthM);
  const double across = p.y() - row * kBoardWidthM;
  const double along = shifted - column * kBoardLengthM;
  const double board =
      Lattice(static_cast<std::int64_t>(row), static_cast<std::int64_t>(column), 1, seed);
  const double grain = Noise2({p.x() / 6, p.y() + 0.01 * board}, 0.006, seed + 1) +
                       0.6 * Noise2({p.x() / 4, p.y() + 3 * board}, 0.025, seed + 2);
  const bool gap = across < kBoardGapM || along < kBoardGapM;
  const Eigen::Vector3f oak(0.36f, 0.21f, 0.11f);
  return Scaled(oak, (1.0 + 0.28 * board + 0.16 * grain) * (gap ? 0.45 : 1.0));
}

Eigen::Vector3f Carpet(const Eigen::Vector2d& p, std::uint64_t seed) {
  const double pile =
      Noise2(p, 0.006, seed) + 0.7 * Noise2(p, 0.03, seed + 1) + 0.5 * Noise2(p, 0.3, seed + 2);
  return Scaled(Eigen::Vector3f(0.20f, 0.22f, 0.26f), 1.0 + 0.22 * pile);
}

Eigen::Vector3f Tiles(const Eigen::Vector2d& p, std::uint64_t seed) {
  constexpr double kTileM = 0.3;     // a side, a common size of floor tiles
  constexpr double kJointM = 0.006;  // width of the mortar between tiles
  const Eigen::Vector2d tile = (p / kTileM).array().floor();
  const Eigen::Vector2d inside = p - tile * kTileM;
  if (inside.minCoeff() < kJointM) return Eigen::Vector3f::Constant(0.18f);
  const double tone =
      Lattice(static_cast<std::int64_t>(tile.x()), static_cast<std::int64_t>(tile.y()), 3, seed);
  return Scaled(Eigen::Vector3f(0.46f, 0.40f, 0.33f),
                1.0 + 0.15 * tone + 0.1 * Noise2(p, 0.05, seed));
}

}  // namespace

double SmoothNoise(const Eigen::Vector3d& p, std::uint64_t seed) {
  const std::int64_t x = Floor(p.x());
  const std::int64_t y = Floor(p.y());
  const std::int64_t z = Floor(p.z());
  const double r = Fade(p.x() - static_cast<double>(x));
  const double s = Fade(p.y() - static_cast<double>(y));
  const double t = Fade(p.z() - static_cast<double>(z));
  const auto along_x = [&](std::int64_t j, std::int64_t k) {
    const double low = Lattice(x, j, k, seed);
    return low + r * (Lattice(x + 1, j, k, seed) - low);
  };
  const auto layer = [&](std::int64_t k) {
    const double low = along_x(y, k);
    return low + s * (along_x(y + 1, k) - low);
  };
  const double low = layer(z);
  return low + t * (layer(z + 1) - low);
}

Eigen::Vector3f FloorColour(std::string_view kind, const Eigen::Vector2d& p_m, std::uint64_t seed) {
  if (kind == "carpet") return Carpet(p_m, seed);
  if (kind == "tiles") return Tiles(p_m, seed);
  return WoodFloor(p_m, seed);
}

Eigen::Vector3f WallColour(const Rgb8& paint, const Eigen::Vector2d& p_m, std::uint64_t seed) {
  constexpr double kSkirtingM = 0.08;  // height of the white board along the floor
  if (p_m.y() < kSkirtingM)
    return Scaled(Linear({236, 232, 224}), 1.0 + 0.03 * Noise2(p_m, 0.05, seed));
  return Scaled(Linear(paint),
                1.0 + 0.03 * Noise2(p_m, 0.01, seed) + 0.05 * Noise2(p_m, 0.7, seed + 1));
}

Eigen::Vector3f PosterColour(int number,
                             const Eigen::Vector2d& p_m,
                             const Eigen::Vector2d& extent_m,
                             std::uint64_t seed) {
  constexpr double kFrameM = 0.025;  // of the dark frame around a poster
  const double to_edge = std::min(p_m.minCoeff(), (extent_m - p_m).minCoeff());
  if (to_edge < kFrameM) return Eigen::Vector3f(0.05f, 0.045f, 0.04f);
  Random random(seed, "poster", static_cast<std::uint64_t>(number));
  const auto colour = [&] {
    return Eigen::Vector3f(static_cast<float>(random.Uniform(0.05, 0.8)),
                           static_cast<float>(random.Uniform(0.05, 0.8)),
                           static_cast<float>(random.Uniform(0.05, 0.8)));
  };
  Eigen::Vector3f paint = colour();
  const Eigen::Vector2d p = p_m.cwiseQuotient(extent_m);
  // Hills before a sky: bands whose upper edge is noise, the later the nearer.
  const Eigen::Vector3f sky = colour();
  paint = paint + static_cast<float>(p.y()) * (sky - paint);
  constexpr int kNumHills = 5;  // bands, each 0.15 of the height lower than the last
  for (int i = 0; i < kNumHills; ++i) {
    const Eigen::Vector3f hill = colour();
    const double height =
        0.75 - 0.15 * i + 0.12 * SmoothNoise({p.x() * (2 + i), i + 0.5, number + 0.5}, seed);
    if (p.y() < height) paint = hill;
  }
  constexpr int kNumSpots = 12;  // discs with edges that cameras can track
  for (int i = 0; i < kNumSpots; ++i) {
    const Eigen::Vector2d centre(random.Uniform(), random.Uniform());
    const double radius = random.Uniform(0.02, 0.07);
    const Eigen::Vector3f spot = colour();
    if ((p - centre).norm() < radius) paint = spot;
  }
  return Scaled(paint, 1.0 + 0.1 * Noise2(p_m, 0.01, seed + static_cast<std::uint64_t>(number)));
}

Eigen::Vector3f Linear(const Rgb8& colour) {
  static const std::array<float, 256> kLinear = [] {
    std::array<float, 256> values{};
    for (std::size_t c = 0; c < values.size(); ++c) {
      const double s = static_cast<double>(c) / 255.0;
      values[c] =
          static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return {kLinear[colour.r], kLinear[colour.g], kLinear[colour.b]};
}

}  // namespace deepslam::synth

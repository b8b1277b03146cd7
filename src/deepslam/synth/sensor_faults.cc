#include "deepslam/synth/sensor_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"

namespace deepslam::synth {
namespace {

// Share of light that comes back from a face seen under a cosine; below, the pattern is lost.
constexpr float kLostCosine = 0.12f;
constexpr float kSureCosine = 0.25f;  // from here on slopes lose nothing
// A polished face gives depth only when its mirror image of the projector is not far off the axis.
constexpr float kMirrorCosine = 0.97f;
// Neighbouring depths further apart than this are two surfaces, relative.
constexpr double kEdgeStep = 0.03;
// Patches of missing depth, px.
constexpr int kHolePatchPx = 16;
constexpr float kColourNoise = 0.010f;  // of full scale
constexpr double kVignetting = 0.18;    // darkening at the corners
constexpr int kNumTones = 4096;         // a step is a tenth of a display value at most

std::uint64_t RowItem(std::uint64_t item, std::size_t row) { return item * 65'536 + row; }

// Nearest whole number of one that is not far below zero; std::lround and std::floor are calls on
// machines of the baseline instruction set.
int Nearest(double x) {
  constexpr int kBelow = 1 << 16;  // lifts the value above 0, where a cast rounds down
  return static_cast<int>(x + (kBelow + 0.5)) - kBelow;
}

// To 1e-4 rad, of a cosine in [0, 1] (Abramowitz, Stegun 4.4.45).
double QuickAcos(float cosine) {
  const float c = cosine;
  return static_cast<double>(std::sqrt(1 - c) *
                             (1.5707288f + c * (-0.2121144f + c * (0.0742610f - 0.0187293f * c))));
}

// Nearly normal, unit variance: the sum of eight uniform ones. Calls of logarithm and cosine for
// every pixel would cost more than all else here.
float QuickNormal(Random& random) {
  // Two 16-bit numbers of a word, which add without meeting.
  constexpr std::uint64_t kHalves = 0x0000FFFF0000FFFFULL;
  const std::uint64_t a = random.Next();
  const std::uint64_t b = random.Next();
  std::uint64_t sum = (a & kHalves) + (a >> 16 & kHalves) + (b & kHalves) + (b >> 16 & kHalves);
  sum = (sum & 0xFFFFFFFF) + (sum >> 32);
  // Mean 8 x 32767.5, variance 8 x 65536^2 / 12.
  return (static_cast<float>(sum) - 262140.0f) * 1.868813e-5f;
}

// One frame's noise, nearly normal, unit variance; what a pixel shares with its neighbours falls
// with their distance (a first-order autoregressive filter along rows, then along columns).
Image<float> SharedNoise(
    int width, int height, double reach_px, std::string_view name, const FrameSeed& seed) {
  constexpr std::size_t kColumnsPerTask = 64;  // of one task: 256 bytes a row, whole cache lines
  Image<float> noise(width, height);
  const auto kept = reach_px > 0 ? static_cast<float>(std::exp(-1 / reach_px)) : 0.0f;
  const float fresh = std::sqrt(1 - kept * kept);
  ParallelFor(static_cast<std::size_t>(height), [&](std::size_t row) {
    Random random(seed.seed, name, RowItem(seed.frame, row));
    float* const values = noise.row(static_cast<int>(row));
    float last = QuickNormal(random);
    values[0] = last;
    for (int u = 1; u < width; ++u) {
      last = kept * last + fresh * QuickNormal(random);
      values[u] = last;
    }
  });
  if (!(kept > 0)) return noise;
  ParallelForChunks(
      static_cast<std::size_t>(width), kColumnsPerTask, [&](std::size_t begin, std::size_t end) {
        for (int v = 1; v < height; ++v) {
          const float* const above = noise.row(v - 1);
          float* const values = noise.row(v);
          for (std::size_t u = begin; u < end; ++u) values[u] = kept * above[u] + fresh * values[u];
        }
      });
  return noise;
}

// Share of a normal distribution below x: turns a noise into an even one.
double NormalShare(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// A pixel is in shadow when the eye beside the camera has a nearer surface before it. An eye a
// distance b to the left has columns at u + f b / z: one that a column further left has reached
// already is hidden. An eye to the right: the other way round.
std::vector<std::uint8_t> ShadowOfRow(const DepthImage& depth_m,
                                      int v,
                                      double fx,
                                      const DepthSensor& sensor) {
  // Half a pixel of slack: neighbours on one slanted surface may swap by rounding.
  constexpr double kSlackPx = 0.5;
  const int width = depth_m.width();
  std::vector<std::uint8_t> shadow(static_cast<std::size_t>(width), 0);
  const auto look = [&](double eye_m, bool from_left) {
    double reach = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < width; ++i) {
      const int u = from_left ? i : width - 1 - i;
      const auto d = static_cast<double>(depth_m(u, v));
      if (d <= 0) continue;
      const double column = i + fx * eye_m / d;
      if (column < reach - kSlackPx) shadow[static_cast<std::size_t>(u)] = 1;
      reach = std::max(reach, column);
    }
  };
  if (sensor.left_eye_m > 0) look(sensor.left_eye_m, true);
  if (sensor.right_eye_m > 0) look(sensor.right_eye_m, false);
  return shadow;
}

// 1 where depth is missing: smooth noise of the image below its quantile, so that the share is
// exact.
Mask MissingPatches(int width, int height, double share, const FrameSeed& seed) {
  if (!(share > 0)) return {};
  const int cells_x = width / kHolePatchPx + 2;
  const int cells_y = height / kHolePatchPx + 2;
  Image<float> lattice(cells_x, cells_y);
  Random random(seed.seed, "missing", seed.frame);
  for (float& value : lattice) value = static_cast<float>(random.Uniform());
  Image<float> noise(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int x = u / kHolePatchPx;
      const int y = v / kHolePatchPx;
      const float s = static_cast<float>(u % kHolePatchPx) / kHolePatchPx;
      const float t = static_cast<float>(v % kHolePatchPx) / kHolePatchPx;
      noise(u, v) = (1 - t) * ((1 - s) * lattice(x, y) + s * lattice(x + 1, y)) +
                    t * ((1 - s) * lattice(x, y + 1) + s * lattice(x + 1, y + 1));
    }
  }
  std::vector<float> sorted(noise.begin(), noise.end());
  const auto rank = std::min(sorted.size() - 1,
                             static_cast<std::size_t>(share * static_cast<double>(sorted.size())));
  const float limit = share >= 1 ? 2.0f : OrderStatistic(sorted, rank);
  Mask missing(width, height, 0);
  std::transform(noise.begin(), noise.end(), missing.begin(), [limit](float value) {
    return static_cast<std::uint8_t>(value < limit ? 1 : 0);
  });
  return missing;
}

// Noise of one frame, per measured cell; empty where it is switched off.
struct NoiseFields {
  Image<float> axial;
  Image<float> lateral_u;
  Image<float> lateral_v;
  Image<float> loss;

  NoiseFields(int width, int height, const SceneDescription& scene, const FrameSeed& seed) {
    const SensorFaults& faults = scene.faults;
    const auto field = [&](std::string_view name) {
      return SharedNoise(width, height, scene.sensor.noise_reach_px, name, seed);
    };
    if (faults.axial_noise) axial = field("axial");
    if (faults.lateral_noise) lateral_u = field("lateral u");
    if (faults.lateral_noise) lateral_v = field("lateral v");
    if (faults.grazing_holes || faults.dark_holes) loss = field("loss");
  }
};

// One frame's reading, cell by cell.
class Reading {
 public:
  Reading(const SensedView& truth,
          const PinholeCamera& camera,
          const Pose3& world_from_camera,
          const SceneDescription& scene,
          const NoiseFields& noise)
      : noise_(noise),
        truth_(truth),
        camera_(camera),
        sensor_(scene.sensor),
        faults_(scene.faults),
        cosines_(camera.width, camera.height) {
    const Eigen::Matrix3f world_from_camera_axes =
        world_from_camera.rotation.toRotationMatrix().cast<float>();
    ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
      const int v = static_cast<int>(row);
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector3f ray = camera.Ray(u, v).cast<float>();
        const Eigen::Vector3f& normal = truth.view.hits(u, v).normal_world;
        cosines_(u, v) =
            std::clamp(-normal.dot(world_from_camera_axes * ray) / ray.norm(), 0.0f, 1.0f);
      }
    });
  }

  // Depth of the surface that cell (x, y), whose middle is pixel (u, v), takes for its own; 0 where
  // it sees none.
  [[nodiscard]] float At(
      int x, int y, int u, int v, const std::vector<std::uint8_t>& shadow, Random& random) const {
    if (faults_.rim && OnRim(u, v)) return 0;
    if (faults_.lateral_noise) {
      const double deviation =
          faults_.noise_scale * LateralDeviation(sensor_, QuickAcos(cosines_(u, v)));
      u = Moved(u, deviation * static_cast<double>(noise_.lateral_u(x, y)), camera_.width);
      v = Moved(v, deviation * static_cast<double>(noise_.lateral_v(x, y)), camera_.height);
    }
    double depth = static_cast<double>(truth_.view.depth_m(u, v));
    if (depth <= 0 || (!truth_.blind.empty() && truth_.blind(u, v) != 0)) return 0;
    const float cosine = cosines_(u, v);
    if (faults_.shadows && shadow[static_cast<std::size_t>(u)] != 0) return 0;
    if (IsHole(x, y, u, v, depth, cosine)) return 0;
    if (faults_.mixed_pixels) depth = Mixed(u, v, depth, random);
    if (faults_.range_bias) depth += RangeBias(sensor_, depth);
    if (faults_.axial_noise) {
      depth += faults_.noise_scale * AxialDeviation(sensor_, depth, QuickAcos(cosine)) *
               static_cast<double>(noise_.axial(x, y));
      depth = std::max(0.05, depth);
    }
    if (faults_.quantisation) depth = QuantisedDepth(sensor_, depth);
    return static_cast<float>(depth);
  }

 private:
  [[nodiscard]] bool OnRim(int u, int v) const {
    const auto& [left, right, top, bottom] = sensor_.rim;
    return u < left * camera_.width || u >= (1 - right) * camera_.width ||
           v < top * camera_.height || v >= (1 - bottom) * camera_.height;
  }

  static int Moved(int place, double by_px, int size) {
    return std::clamp(Nearest(place + by_px), 0, size - 1);
  }

  [[nodiscard]] bool IsHole(int x, int y, int u, int v, double depth, float cosine) const {
    if (faults_.range_limits && (depth < sensor_.min_range_m || depth > sensor_.max_range_m))
      return true;
    if (faults_.shiny_holes && !truth_.shiny.empty() && truth_.shiny(u, v) != 0 &&
        cosine < kMirrorCosine)
      return true;
    double lost = 0;  // how likely
    if (faults_.grazing_holes)
      lost = static_cast<double>((kSureCosine - cosine) / (kSureCosine - kLostCosine));
    if (faults_.dark_holes && !truth_.reflectance.empty()) {
      const double signal = InfraredReflectance(static_cast<double>(truth_.reflectance(u, v))) *
                            static_cast<double>(cosine) / (depth * depth);
      lost = std::max(lost,
                      (sensor_.signal_sure - signal) / (sensor_.signal_sure - sensor_.signal_lost));
    }
    // Neighbours are lost together: holes are patches, with ragged edges.
    return lost >= 1 || (lost > 0 && NormalShare(static_cast<double>(noise_.loss(x, y))) < lost);
  }

  [[nodiscard]] double Mixed(int u, int v, double depth, Random& random) const {
    double other = depth;
    for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (!truth_.view.depth_m.Contains(u + du, v + dv)) continue;
      const double d = static_cast<double>(truth_.view.depth_m(u + du, v + dv));
      if (d > 0 && std::abs(d - depth) > std::abs(other - depth)) other = d;
    }
    if (std::abs(other - depth) < kEdgeStep * depth || random.Uniform() >= sensor_.mixed_share)
      return depth;
    return depth + 0.5 * random.Uniform() * (other - depth);
  }

  const NoiseFields& noise_;
  const SensedView& truth_;
  const PinholeCamera& camera_;
  const DepthSensor& sensor_;
  const SensorFaults& faults_;
  Image<float> cosines_;  // between each pixel's ray and its face's normal
};

// Fills in between cells: as phones do, across edges as well, but never far from a measurement.
DepthImage Interpolated(const DepthImage& cells, int cell_px, int width, int height) {
  DepthImage depth(width, height, 0.0f);
  ParallelFor(static_cast<std::size_t>(height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < width; ++u) {
      const double x = (u + 0.5) / cell_px - 0.5;
      const double y = (v + 0.5) / cell_px - 0.5;
      double sum = 0;
      double weights = 0;
      for (int k = 0; k < 4; ++k) {
        const int cu = std::clamp(static_cast<int>(std::floor(x)) + (k & 1), 0, cells.width() - 1);
        const int cv =
            std::clamp(static_cast<int>(std::floor(y)) + (k >> 1), 0, cells.height() - 1);
        const auto d = static_cast<double>(cells(cu, cv));
        const double weight =
            std::max(0.0, 1 - std::abs(x - cu)) * std::max(0.0, 1 - std::abs(y - cv));
        if (d <= 0) continue;
        sum += weight * d;
        weights += weight;
      }
      if (weights >= 0.5) depth(u, v) = static_cast<float>(sum / weights);
    }
  });
  return depth;
}

// Gaussian of 0.6 px, which a cheap lens and the colour filter leave. The border is repeated.
Image<Eigen::Vector3f> Blurred(const Image<Eigen::Vector3f>& from) {
  constexpr float kKernelSide = 0.166f;    // this twice and kKernelMiddle add up to 1
  constexpr float kKernelMiddle = 0.668f;  // its tail beyond one pixel is cut off
  const int last_u = from.width() - 1;
  const int last_v = from.height() - 1;
  const auto mean = [&](const Eigen::Vector3f& a,
                        const Eigen::Vector3f& middle,
                        const Eigen::Vector3f& b) -> Eigen::Vector3f {
    return kKernelMiddle * middle + kKernelSide * (a + b);
  };
  Image<Eigen::Vector3f> out(from.width(), from.height(), Eigen::Vector3f::Zero());
  ParallelFor(static_cast<std::size_t>(from.height()), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    const Eigen::Vector3f* const above = from.row(std::max(v - 1, 0));
    const Eigen::Vector3f* const here = from.row(v);
    const Eigen::Vector3f* const below = from.row(std::min(v + 1, last_v));
    std::vector<Eigen::Vector3f> columns(static_cast<std::size_t>(from.width()),
                                         Eigen::Vector3f::Zero());
    for (std::size_t u = 0; u < columns.size(); ++u) columns[u] = mean(above[u], here[u], below[u]);
    for (int u = 0; u <= last_u; ++u) {
      const auto n = static_cast<std::size_t>(u);
      out(u, v) = mean(columns[static_cast<std::size_t>(std::max(u - 1, 0))],
                       columns[n],
                       columns[static_cast<std::size_t>(std::min(u + 1, last_u))]);
    }
  });
  return out;
}

// Where a moved camera has the points of another one's pixels: their homogeneous place there is
// linear in the pixel and the depth.
class Pixels {
 public:
  Pixels(const PinholeCamera& camera, const Pose3& moved_from_camera) {
    Eigen::Matrix3d lens;
    lens << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    turn_ = (lens * moved_from_camera.rotation.toRotationMatrix() * lens.inverse()).cast<float>();
    shift_ = (lens * moved_from_camera.translation_m).cast<float>();
  }
  [[nodiscard]] Eigen::Vector2f Of(int u, int v, float depth_m) const {
    const Eigen::Vector3f h =
        turn_ * Eigen::Vector3f(static_cast<float>(u), static_cast<float>(v), 1) + shift_ / depth_m;
    return h.head<2>() / h.z();
  }

 private:
  Eigen::Matrix3f turn_;
  Eigen::Vector3f shift_;
};

// Display value by the root of the linear value: even steps of the root are nearly even to the eye.
std::vector<std::uint8_t> Tones() {
  std::vector<std::uint8_t> tones(kNumTones);
  for (int i = 0; i < kNumTones; ++i) {
    const double root = i / (kNumTones - 1.0);
    const double c = root * root;
    const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
    tones[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::lround(255 * s));
  }
  return tones;
}

}  // namespace

DepthImage ApplyDepthFaults(const SensedView& truth,
                            const PinholeCamera& camera,
                            const Pose3& world_from_camera,
                            const SceneDescription& scene,
                            const FrameSeed& seed) {
  const int cell_px = scene.faults.lateral_noise ? std::max(1, scene.sensor.cell_px) : 1;
  DepthImage cells(
      (camera.width + cell_px - 1) / cell_px, (camera.height + cell_px - 1) / cell_px, 0.0f);
  const NoiseFields noise(cells.width(), cells.height(), scene, seed);
  const Reading reading(truth, camera, world_from_camera, scene, noise);
  ParallelFor(static_cast<std::size_t>(cells.height()), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    const int v = std::min(y * cell_px + cell_px / 2, camera.height - 1);
    Random random(seed.seed, "depth", RowItem(seed.frame, row));
    const std::vector<std::uint8_t> shadow =
        ShadowOfRow(truth.view.depth_m, v, camera.fx, scene.sensor);
    for (int x = 0; x < cells.width(); ++x) {
      const int u = std::min(x * cell_px + cell_px / 2, camera.width - 1);
      cells(x, y) = reading.At(x, y, u, v, shadow, random);
    }
  });
  DepthImage seen =
      cell_px > 1 ? Interpolated(cells, cell_px, camera.width, camera.height) : std::move(cells);
  const Mask missing =
      MissingPatches(camera.width, camera.height, scene.faults.missing_share, seed);
  if (!missing.empty()) {
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        if (missing(u, v) != 0) seen(u, v) = 0;
      }
    }
  }
  return seen;
}

ColourImage DevelopColour(const Image<Eigen::Vector3f>& radiance,
                          const SensorFaults& faults,
                          double gain,
                          const FrameSeed& seed) {
  const int width = radiance.width();
  const int height = radiance.height();
  const std::vector<std::uint8_t> tones = Tones();
  const Image<Eigen::Vector3f> blurred =
      faults.colour_noise ? Blurred(radiance) : Image<Eigen::Vector3f>();
  const Image<Eigen::Vector3f>& picture = faults.colour_noise ? blurred : radiance;
  const auto display = [&](float linear) {
    const float root = std::sqrt(std::clamp(linear, 0.0f, 1.0f));
    return tones[static_cast<std::size_t>(root * (kNumTones - 1) + 0.5f)];
  };
  ColourImage colour(width, height);
  ParallelFor(static_cast<std::size_t>(height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    Random random(seed.seed, "colour", RowItem(seed.frame, row));
    for (int u = 0; u < width; ++u) {
      Eigen::Vector3f c = static_cast<float>(gain) * picture(u, v);
      if (faults.colour_noise) {
        const double x = 2.0 * u / width - 1;
        const double y = 2.0 * v / height - 1;
        c *= static_cast<float>(1 - kVignetting * 0.5 * (x * x + y * y));
        // Photon noise grows with the root of the light.
        for (int k = 0; k < 3; ++k) {
          c[k] += kColourNoise * QuickNormal(random) * std::sqrt(std::max(c[k], 0.02f));
        }
      }
      colour(u, v) = {display(c.x()), display(c.y()), display(c.z())};
    }
  });
  return colour;
}

Image<Eigen::Vector3f> MotionBlurred(const Image<Eigen::Vector3f>& radiance,
                                     const DepthImage& depth_m,
                                     const PinholeCamera& camera,
                                     const Pose3& first_from_camera,
                                     const Pose3& last_from_camera) {
  constexpr float kLeastBlurPx = 0.3f;  // less blurs nothing that shows
  constexpr float kOpenDepthM = 10;     // where nothing is hit
  // Bounds the time of fast turns; longer ways are sampled more coarsely.
  constexpr int kMaxTaps = 24;
  Image<Eigen::Vector3f> blurred(camera.width, camera.height, Eigen::Vector3f::Zero());
  const Pixels first(camera, first_from_camera);
  const Pixels last(camera, last_from_camera);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < camera.width; ++u) {
      const float depth = depth_m(u, v) > 0 ? depth_m(u, v) : kOpenDepthM;
      const Eigen::Vector2f way = last.Of(u, v, depth) - first.Of(u, v, depth);
      const float length_px = way.norm();
      // Not finite where the point is behind a camera.
      if (!(length_px > kLeastBlurPx) || !(length_px < 1e4f)) {
        blurred(u, v) = radiance(u, v);
        continue;
      }
      const int num_taps = std::min(kMaxTaps, static_cast<int>(length_px) + 2);
      const Eigen::Vector2f step = way / static_cast<float>(num_taps);
      const Eigen::Vector2f begin =
          Eigen::Vector2f(static_cast<float>(u), static_cast<float>(v)) - 0.5f * way + 0.5f * step;
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int i = 0; i < num_taps; ++i) {
        const Eigen::Vector2f p = begin + static_cast<float>(i) * step;
        const int x = std::clamp(Nearest(static_cast<double>(p.x())), 0, camera.width - 1);
        const int y = std::clamp(Nearest(static_cast<double>(p.y())), 0, camera.height - 1);
        sum += radiance(x, y);
      }
      blurred(u, v) = sum / static_cast<float>(num_taps);
    }
  });
  return blurred;
}

}  // namespace deepslam::synth

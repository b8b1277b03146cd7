#include "deepslam/eval/shape_similarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "deepslam/core/random.h"
#include "deepslam/eval/marching_cubes.h"
#include "deepslam/eval/nearest_points.h"

namespace deepslam::eval {
namespace {

constexpr int kPooledAbove = 100;    // Pix3D's evaluation pools larger volumes first
constexpr int kPool = 4;             // and by so much
constexpr int kMaxVolumeSide = 512;  // samples a side: bounds memory, 512 MiB of floats

Volume MaxPool(const Volume& in) {
  const int size = in.size[0] / kPool;
  Volume out({size, size, size});
  for (int i = 0; i < size * kPool; ++i) {
    for (int j = 0; j < size * kPool; ++j) {
      for (int k = 0; k < size * kPool; ++k) {
        float& value = out(i / kPool, j / kPool, k / kPool);
        value = std::max(value, in(i, j, k));
      }
    }
  }
  return out;
}

struct IndexBox {
  std::array<int, 3> min = {kMaxVolumeSide, kMaxVolumeSide, kMaxVolumeSide};
  std::array<int, 3> max = {-1, -1, -1};
};

IndexBox BoxOf(const Volume& volume) {
  IndexBox box;
  for (int i = 0; i < volume.size[0]; ++i) {
    for (int j = 0; j < volume.size[1]; ++j) {
      for (int k = 0; k < volume.size[2]; ++k) {
        if (!(volume(i, j, k) >= kShapeThreshold)) continue;
        const std::array<int, 3> at = {i, j, k};
        for (std::size_t n = 0; n < 3; ++n) {
          box.min[n] = std::min(box.min[n], at[n]);
          box.max[n] = std::max(box.max[n], at[n]);
        }
      }
    }
  }
  return box;
}

// Trilinear inside the box, in samples from its first; zero outside.
double Interpolate(const Volume& volume, const IndexBox& box, const Eigen::Vector3d& p) {
  std::array<int, 3> low{};
  std::array<double, 3> part{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < 3; ++n) {
    const double x = p[static_cast<Eigen::Index>(n)];
    const int last = box.max[n] - box.min[n];
    if (x < 0 || x > last) return 0;
    const int floor = std::min(static_cast<int>(x), std::max(0, last - 1));
    low[n] = box.min[n] + floor;
    high[n] = std::min(low[n] + 1, box.max[n]);
    part[n] = x - floor;
  }
  double sum = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto upper = [&](unsigned n) { return ((corner >> n) & 1U) != 0; };
    double weight = 1;
    for (unsigned n = 0; n < 3; ++n) weight *= upper(n) ? part[n] : 1 - part[n];
    if (weight == 0) continue;
    sum += weight * static_cast<double>(volume(upper(0) ? high[0] : low[0],
                                               upper(1) ? high[1] : low[1],
                                               upper(2) ? high[2] : low[2]));
  }
  return sum;
}

Status CheckCube(const Volume& volume) {
  const auto& [x, y, z] = volume.size;
  if (x != y || x != z || x < 2 || x > kMaxVolumeSide) {
    return InvalidInput("shape: the volume must be a cube of 2 to 512 samples a side");
  }
  if (volume.values.size() !=
      static_cast<std::size_t>(x) * static_cast<std::size_t>(y) * static_cast<std::size_t>(z)) {
    return InvalidInput("shape: the volume's values do not fill its size");
  }
  if (std::none_of(volume.values.begin(), volume.values.end(), [](float v) {
        return v >= kShapeThreshold;
      })) {
    return InvalidInput("shape: the volume is empty: no value reaches 0.1");
  }
  return Ok();
}

Eigen::Vector3d PointIn(const TriangleMesh& mesh,
                        const std::array<std::uint32_t, 3>& face,
                        Random& random) {
  const double root = std::sqrt(random.Uniform());
  const double second = random.Uniform();
  const auto corner = [&](std::size_t n) { return mesh.vertices[face[n]].cast<double>(); };
  return (1 - root) * corner(0) + root * (1 - second) * corner(1) + root * second * corner(2);
}

void CentreAndScale(std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d low = points.front();
  Eigen::Vector3d high = points.front();
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double longest = (high - low).maxCoeff();
  for (Eigen::Vector3d& p : points) p = ((p - 0.5 * (low + high)) / longest).eval();
}

}  // namespace

Result<Volume> NormaliseForIou(const Volume& volume) {
  if (Status status = CheckCube(volume); !status.ok()) return status.error();
  const Volume pooled = volume.size[0] > kPooledAbove ? MaxPool(volume) : volume;
  const IndexBox box = BoxOf(pooled);
  if (box.max[0] < 0) return InvalidInput("shape: the volume is empty: no value reaches 0.1");
  Eigen::Vector3d extent;
  for (std::size_t n = 0; n < 3; ++n)
    extent[static_cast<Eigen::Index>(n)] = box.max[n] - box.min[n];
  const double side = extent.maxCoeff();
  const Eigen::Vector3d start = 0.5 * (extent - Eigen::Vector3d::Constant(side));
  // The last sample is exactly the end, so that rounding does not put it outside.
  const auto at = [&](int axis, int n) {
    return start[axis] + (n == kIouSize - 1 ? side : n * (side / (kIouSize - 1)));
  };
  Volume out({kIouSize, kIouSize, kIouSize});
  for (int i = 0; i < kIouSize; ++i) {
    for (int j = 0; j < kIouSize; ++j) {
      for (int k = 0; k < kIouSize; ++k) {
        out(i, j, k) = static_cast<float>(
            Interpolate(pooled, box, Eigen::Vector3d(at(0, i), at(1, j), at(2, k))));
      }
    }
  }
  return out;
}

std::vector<double> IouPerThreshold(const Volume& a, const Volume& b) {
  DEEPSLAM_CHECK(a.values.size() == b.values.size(), "volumes of different size");
  std::vector<double> iou;
  for (int n = 1; n <= kNumIouThresholds; ++n) {
    const auto threshold = static_cast<float>(0.01 * n);
    std::size_t both = 0;
    std::size_t either = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      const bool in_a = a.values[i] > threshold;
      const bool in_b = b.values[i] > threshold;
      both += in_a && in_b ? 1 : 0;
      either += in_a || in_b ? 1 : 0;
    }
    iou.push_back(either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0.0);
  }
  return iou;
}

SetIou BestOverSet(std::span<const std::vector<double>> pairs) {
  SetIou best;
  if (pairs.empty()) return best;
  best.mean = -1;
  for (std::size_t n = 0; n < kNumIouThresholds; ++n) {
    double sum = 0;
    for (const std::vector<double>& pair : pairs) sum += pair[n];
    const double mean = sum / static_cast<double>(pairs.size());
    if (mean <= best.mean) continue;
    best.mean = mean;
    best.threshold = 0.01 * static_cast<double>(n + 1);
    best.each.clear();
    for (const std::vector<double>& pair : pairs) best.each.push_back(pair[n]);
  }
  return best;
}

Result<std::vector<Eigen::Vector3d>> SampleForChamfer(const Volume& volume, std::uint64_t seed) {
  if (Status status = CheckCube(volume); !status.ok()) return status.error();
  const TriangleMesh mesh = MarchingCubes(volume, kShapeThreshold);
  if (mesh.empty()) return InvalidInput("shape: the volume has no surface at 0.1");
  Random random(seed, "chamfer", 0);
  std::vector<Eigen::Vector3d> points;
  while (points.size() < kNumChamferPoints) {
    for (const auto& face : mesh.faces) points.push_back(PointIn(mesh, face, random));
  }
  for (std::size_t i = 0; i < kNumChamferPoints; ++i) {
    std::swap(points[i], points[i + random.Index(points.size() - i)]);
  }
  points.resize(kNumChamferPoints);
  CentreAndScale(points);
  return points;
}

double ChamferDistance(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b) {
  const auto mean = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  return mean(NearestDistances(a, b)) + mean(NearestDistances(b, a));
}

}  // namespace deepslam::eval

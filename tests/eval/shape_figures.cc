// IoU per threshold, the points that distances are taken between, and Chamfer distance of two
// volumes, as JSON, for shape_figures_test.py to compare with its own:
//   deepslam_shape_figures A B
// A, B: cubes of little-endian floats, the last index fastest.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "deepslam/eval/shape_similarity.h"

namespace deepslam::eval {
namespace {

Volume ReadVolume(const char* file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const auto side =
      static_cast<int>(std::lround(std::cbrt(static_cast<double>(bytes.size()) / sizeof(float))));
  Volume volume({side, side, side});
  if (volume.values.size() * sizeof(float) != bytes.size()) std::exit(2);
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(volume.values.data()));
  return volume;
}

void PrintPoints(const char* name, const std::vector<Eigen::Vector3d>& points) {
  std::printf(", \"%s\": [", name);
  for (std::size_t i = 0; i < points.size(); ++i)
    std::printf("%s[%.17g, %.17g, %.17g]",
                i == 0 ? "" : ", ",
                points[i].x(),
                points[i].y(),
                points[i].z());
  std::printf("]");
}

void Print(const Volume& a, const Volume& b) {
  std::printf("{\"iou\": [");
  const std::vector<double> iou =
      IouPerThreshold(NormaliseForIou(a).value(), NormaliseForIou(b).value());
  for (std::size_t i = 0; i < iou.size(); ++i) std::printf("%s%.17g", i == 0 ? "" : ", ", iou[i]);
  const auto points_a = SampleForChamfer(a, 1).value();
  const auto points_b = SampleForChamfer(b, 1).value();
  std::printf("], \"chamfer\": %.17g", ChamferDistance(points_a, points_b));
  PrintPoints("points_a", points_a);
  PrintPoints("points_b", points_b);
  std::printf("}\n");
}

}  // namespace
}  // namespace deepslam::eval

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  deepslam::eval::Print(deepslam::eval::ReadVolume(argv[1]), deepslam::eval::ReadVolume(argv[2]));
  return 0;
}

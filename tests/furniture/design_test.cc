#include "deepslam/furniture/design.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/furniture/solids.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::furniture {
namespace {

constexpr int kDesigns = 40;

class DesignTest : public testing::TestWithParam<Kind> {
 protected:
  [[nodiscard]] static Design Make(int number) {
    return MakeDesign(GetParam(), Random(7, "design test", static_cast<std::uint64_t>(number)));
  }
};

// Directed edges of the faces [first, last): in a closed oriented surface each occurs once, and so
// does its reverse.
bool IsClosed(const TriangleMesh& mesh, std::size_t first, std::size_t last) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t f = first; f < last; ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (!edges.emplace(mesh.faces[f][c], mesh.faces[f][(c + 1) % 3]).second) return false;
    }
  }
  for (const auto& [from, to] : edges) {
    if (!edges.contains({to, from})) return false;
  }
  return true;
}

double Volume(const TriangleMesh& mesh, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t f = first; f < last; ++f) {
    const auto& face = mesh.faces[f];
    sum += mesh.vertices[face[0]].cast<double>().dot(
        mesh.vertices[face[1]].cast<double>().cross(mesh.vertices[face[2]].cast<double>()));
  }
  return sum / 6;
}

TEST_P(DesignTest, EverySolidIsClosedAndFacesOutwards) {
  for (int n = 0; n < kDesigns; ++n) {
    const Design design = Make(n);
    ASSERT_EQ(design.material_of_face.size(), design.mesh.faces.size());
    for (std::size_t s = 0; s < design.first_faces.size(); ++s) {
      const std::size_t last =
          s + 1 < design.first_faces.size() ? design.first_faces[s + 1] : design.mesh.faces.size();
      EXPECT_TRUE(IsClosed(design.mesh, design.first_faces[s], last)) << n << " solid " << s;
      EXPECT_GT(Volume(design.mesh, design.first_faces[s], last), 0) << n << " solid " << s;
    }
  }
}

TEST_P(DesignTest, KeepsToRealSizesAroundItsMiddle) {
  const SizeRange range = SizeRangeOf(GetParam());
  for (int n = 0; n < kDesigns; ++n) {
    const Design design = Make(n);
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F);
    Eigen::Vector3f high = -low;
    for (const Eigen::Vector3f& vertex : design.mesh.vertices) {
      ASSERT_TRUE(vertex.allFinite());
      low = low.cwiseMin(vertex);
      high = high.cwiseMax(vertex);
    }
    EXPECT_TRUE((high + low).isZero(1e-4F)) << n;
    EXPECT_TRUE((high - low).cast<double>().isApprox(design.size_m, 1e-4)) << n;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(design.size_m[axis], range.min_m[axis]) << n;
      EXPECT_LE(design.size_m[axis], range.max_m[axis]) << n;
    }
  }
}

// Parts hang together: from one voxel all are reached.
TEST_P(DesignTest, IsOnePiece) {
  for (int n = 0; n < kDesigns; n += 2) {
    const Result<VoxelGrid> grid = shape::Voxelize(Make(n).mesh);
    ASSERT_TRUE(grid);
    std::vector<std::uint8_t> left = grid->occupied;
    const auto first = std::find(left.begin(), left.end(), 1);
    ASSERT_NE(first, left.end());
    std::vector<std::size_t> stack = {static_cast<std::size_t>(first - left.begin())};
    *first = 0;
    std::size_t reached = 0;
    while (!stack.empty()) {
      const auto at = static_cast<int>(stack.back());
      stack.pop_back();
      ++reached;
      const int i = at / (kGridSize * kGridSize);
      const int j = at / kGridSize % kGridSize;
      const int k = at % kGridSize;
      for (int a = i - 1; a <= i + 1; ++a) {
        for (int b = j - 1; b <= j + 1; ++b) {
          for (int c = k - 1; c <= k + 1; ++c) {
            if (!VoxelGrid::Contains(a, b, c) || left[VoxelGrid::Index(a, b, c)] == 0) continue;
            left[VoxelGrid::Index(a, b, c)] = 0;
            stack.push_back(VoxelGrid::Index(a, b, c));
          }
        }
      }
    }
    const auto all = std::count(grid->occupied.begin(), grid->occupied.end(), 1);
    EXPECT_GE(static_cast<double>(reached), 0.97 * static_cast<double>(all)) << n;
  }
}

TEST_P(DesignTest, SeedMakesTheDesign) {
  std::set<std::size_t> sizes;
  for (int n = 0; n < kDesigns; ++n) {
    const Design a = Make(n);
    const Design b = Make(n);
    ASSERT_EQ(a.mesh.vertices.size(), b.mesh.vertices.size());
    EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
    EXPECT_EQ(a.mesh.faces, b.mesh.faces);
    sizes.insert(a.mesh.faces.size());
  }
  EXPECT_GE(sizes.size(), 4U) << "designs differ in their parts, not in proportions alone";
}

std::string NameOf(const testing::TestParamInfo<Kind>& info) {
  return std::string(KindName(info.param));
}
INSTANTIATE_TEST_SUITE_P(Kinds, DesignTest, testing::ValuesIn(kKinds), NameOf);

// What rises behind is a back: where the shape tells its front, it is +x.
class FrontTest : public testing::TestWithParam<Kind> {};
TEST_P(FrontTest, FacesPlusX) {
  int clear = 0;
  for (int n = 0; n < kDesigns; ++n) {
    const Result<VoxelGrid> grid = shape::Voxelize(
        MakeDesign(GetParam(), Random(11, "front", static_cast<std::uint64_t>(n))).mesh);
    ASSERT_TRUE(grid);
    EXPECT_EQ(shape::QuarterTurnsToFront(*grid), 0) << n;
    clear += shape::QuarterTurnsToFront(shape::TurnGrid(*grid, 2)) == 2 ? 1 : 0;
  }
  EXPECT_GE(clear, kDesigns / 2) << "most have a back that tells";
}
INSTANTIATE_TEST_SUITE_P(Seats,
                         FrontTest,
                         testing::Values(Kind::kChair,
                                         Kind::kOfficeChair,
                                         Kind::kArmchair,
                                         Kind::kShellChair,
                                         Kind::kSofa,
                                         Kind::kSettee,
                                         Kind::kFramedSofa),
                         NameOf);

TEST(KindsTest, SharesOfAClassAreItsKinds) {
  std::map<std::string_view, double> sum;
  std::set<Kind> seen;
  for (const char* class_name : {"chair", "table", "sofa", "bed", "cabinet", "shelf"}) {
    for (const KindShare& entry : KindsOfClass(class_name)) {
      EXPECT_EQ(ClassName(entry.kind), class_name);
      EXPECT_TRUE(seen.insert(entry.kind).second);
      sum[class_name] += entry.share;
    }
    EXPECT_NEAR(sum[class_name], 1.0, 1e-9) << class_name;
  }
  EXPECT_EQ(seen.size(), kKinds.size());
  EXPECT_TRUE(KindsOfClass("lamp").empty());
}

}  // namespace
}  // namespace deepslam::furniture

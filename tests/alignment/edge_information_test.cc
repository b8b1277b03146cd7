#include "deepslam/alignment/edge_information.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace deepslam::alignment {
namespace {

PyramidLevel Level() {
  PyramidLevel level;
  level.camera = {320, 240, 260, 260, 159.5, 119.5};
  return level;
}

// Iterations that ended with this Hessian, of depth alone.
GaussNewtonState Ended(const Vector6d& diagonal) {
  GaussNewtonState state;
  state.system.hessian = diagonal.asDiagonal();
  return state;
}

Vector6d Strong() { return Vector6d::Constant(1e9); }

TEST(EdgeInformationOf, IsNeverMoreThanTheSystematicErrorAllows) {
  const AlignmentOptions options;
  const Matrix6d information = EdgeInformationOf(Ended(Strong()), Level(), {}, options).information;
  EXPECT_EQ(information, information.transpose());
  const double most = 1 / (options.floor_translation_m * options.floor_translation_m);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LE(information(k, k), most * (1 + 1e-9));
    EXPECT_GT(information(k, k), 0.9 * most);
  }
}

TEST(EdgeInformationOf, GrowsWithWhatIsMeasured) {
  const Matrix6d little =
      EdgeInformationOf(Ended(Vector6d::Constant(1e4)), Level(), {}, {}).information;
  const Matrix6d much =
      EdgeInformationOf(Ended(Vector6d::Constant(1e6)), Level(), {}, {}).information;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> more(much - little);
  EXPECT_GT(more.eigenvalues()[0], 0);
}

// What nothing measures is as well known as the start, or as the prior that held it.
TEST(EdgeInformationOf, OfADegenerateDirectionIsThatOfTheStart) {
  Vector6d diagonal = Strong();
  diagonal[0] = 0;
  const EdgeInformation near = EdgeInformationOf(Ended(diagonal), Level(), {0.01, 0.01}, {});
  const EdgeInformation far = EdgeInformationOf(Ended(diagonal), Level(), {0.5, 0.5}, {});
  EXPECT_LT(near.constraint_ratio, 1e-6);
  const auto sigma_m = [](const EdgeInformation& edge) {
    return std::sqrt(edge.information.inverse()(0, 0));
  };
  EXPECT_NEAR(sigma_m(near), 0.01, 0.002);
  EXPECT_GT(sigma_m(far), 0.3);
  EXPECT_NEAR(EdgeInformationOf(Ended(Strong()), Level(), {}, {}).constraint_ratio, 1, 1e-6);
}

TEST(EdgeInformationOf, OfNothingIsFiniteAndPositive) {
  const EdgeInformation edge = EdgeInformationOf(GaussNewtonState{}, Level(), {}, {});
  EXPECT_TRUE(edge.information.allFinite());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(edge.information);
  EXPECT_GT(eigen.eigenvalues()[0], 0);
  EXPECT_EQ(edge.constraint_ratio, 0);
}

}  // namespace
}  // namespace deepslam::alignment

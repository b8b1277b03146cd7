#include "deepslam/frames/raw_depth.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/frames/stored_depth.h"

namespace deepslam {
namespace {

constexpr double kUnitsPerM[] = {1.0, 256.0, 999.3, 1000.0, 5000.0, 65535.0};

// Every value there is.
RawDepthImage EveryRaw() {
  RawDepthImage raw(256, 256);
  for (std::size_t n = 0; n < raw.size(); ++n) raw.data()[n] = static_cast<std::uint16_t>(n);
  return raw;
}

bool IsDepth(std::size_t raw, double units_per_m) {
  return raw != kNoDepth && raw != kSaturatedDepth &&
         static_cast<double>(raw) / units_per_m <= kMaxDepthM;
}

void ExpectSameBits(float depth_m, float expected_m, std::size_t n) {
  ASSERT_EQ(std::bit_cast<std::uint32_t>(depth_m), std::bit_cast<std::uint32_t>(expected_m))
      << "raw value " << n;
}

TEST(MetresOfRaw, RawValuesAreFoundAgain) {
  const RawDepthImage raw = EveryRaw();
  for (const double units_per_m : kUnitsPerM) {
    const MetresOfRaw metres(units_per_m);
    const DepthImage depth_m = metres.Of(raw);
    const auto found = metres.RawOf(depth_m);
    ASSERT_TRUE(found) << units_per_m;
    for (std::size_t n = 0; n < raw.size(); ++n) {
      ASSERT_EQ(found->data()[n], IsDepth(n, units_per_m) ? n : 0) << units_per_m << " a metre";
      ExpectSameBits(metres[found->data()[n]], depth_m.data()[n], n);
    }
  }
}

// A quotient of whole numbers rounded to double and then to float is the one rounded to float.
TEST(MetresOfRaw, AreTheNearestToTheTrueOnes) {
  const RawDepthImage raw = EveryRaw();
  for (const double units_per_m : kUnitsPerM) {
    const DepthImage depth_m = MetresOfRaw(units_per_m).Of(raw);
    const double units = static_cast<double>(static_cast<float>(units_per_m));
    for (std::size_t n = 0; n < raw.size(); ++n) {
      const double exact_m = IsDepth(n, units_per_m) ? static_cast<double>(n) / units : 0.0;
      ExpectSameBits(depth_m.data()[n], static_cast<float>(exact_m), n);
    }
  }
}

TEST(StoredDepth, GivesTheSameMetresInEitherForm) {
  const RawDepthImage raw = EveryRaw();
  const MetresOfRaw metres(5000.0);
  const DepthImage depth_m = metres.Of(raw);
  const StoredDepth as_raw(raw, metres), as_metres(depth_m);
  std::vector<float> room;
  for (const StoredDepth* const stored : {&as_raw, &as_metres}) {
    ASSERT_EQ(stored->width(), depth_m.width());
    ASSERT_EQ(stored->height(), depth_m.height());
    EXPECT_FALSE(stored->empty());
    for (int v = 0; v + 3 <= depth_m.height(); v += 3) {
      const float* const rows = stored->Rows(v, 3, room);
      EXPECT_TRUE(std::equal(rows, rows + 3 * depth_m.width(), depth_m.row(v))) << "row " << v;
      EXPECT_EQ((*stored)(17, v), depth_m(17, v));
    }
    EXPECT_EQ(StoredDepth(*stored).TakeMetres(), depth_m);
  }
}

TEST(StoredDepth, OfNothingIsEmpty) {
  EXPECT_TRUE(StoredDepth().empty());
  EXPECT_TRUE(StoredDepth(DepthImage()).empty());
  EXPECT_TRUE(StoredDepth(RawDepthImage(), MetresOfRaw(1000.0)).empty());
  EXPECT_TRUE(StoredDepth().TakeMetres().empty());
}

}  // namespace
}  // namespace deepslam

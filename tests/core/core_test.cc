#include <algorithm>
#include <atomic>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/base64.h"
#include "deepslam/core/clock_segments.h"
#include "deepslam/core/disjoint_sets.h"
#include "deepslam/core/every_nth.h"
#include "deepslam/core/nearest_word.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/core/parallel_in_order.h"
#include "deepslam/core/random.h"
#include "deepslam/core/result.h"
#include "deepslam/core/sha256.h"

namespace deepslam {
namespace {

TEST(Sha256, AgreesWithThePublishedVectors) {
  // FIPS 180-2, appendix B.1; and the digest of nothing.
  EXPECT_EQ(Sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256Hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, DoesNotDependOnHowTheBytesArrive) {
  const std::string bytes(1000, 'x');
  Sha256 sha;
  for (std::size_t i = 0; i < bytes.size(); i += 7)
    sha.Update(std::string_view(bytes).substr(i, 7));
  EXPECT_EQ(sha.HexDigest(), Sha256Hex(bytes));
}

TEST(DisjointSets, JoinWhatPairsLeadTo) {
  Random random(3, "pairs", 0);
  constexpr std::size_t kSize = 40;
  DisjointSets sets(kSize);
  std::vector<std::set<std::uint32_t>> expected(kSize);  // by brute force: who is with whom
  for (std::uint32_t x = 0; x < kSize; ++x) expected[x] = {x};
  for (int k = 0; k < 30; ++k) {
    const auto a = static_cast<std::uint32_t>(random.Index(kSize));
    const auto b = static_cast<std::uint32_t>(random.Index(kSize));
    EXPECT_EQ(sets.Join(a, b), !expected[a].contains(b));
    std::set<std::uint32_t> both = expected[a];
    both.insert(expected[b].begin(), expected[b].end());
    for (const std::uint32_t x : both) expected[x] = both;
    for (std::uint32_t x = 0; x < kSize; ++x) EXPECT_EQ(sets.LeastOf(x), *expected[x].begin());
  }
  const std::vector<std::uint32_t> least = sets.LeastOfEach();
  for (std::uint32_t x = 0; x < kSize; ++x) EXPECT_EQ(least[x], *expected[x].begin());
}

TEST(Base64, ReadsBackAndRefusesDamage) {
  for (const std::string& bytes : {std::string(),
                                   std::string("a"),
                                   std::string("ab"),
                                   std::string("abc"),
                                   std::string("\0\xff\x80", 3)}) {
    EXPECT_EQ(*DecodeBase64(EncodeBase64(bytes)), bytes);
  }
  EXPECT_EQ(EncodeBase64("Man"), "TWFu");
  EXPECT_FALSE(DecodeBase64("TWF").ok());
  EXPECT_FALSE(DecodeBase64("TW!u").ok());
  EXPECT_FALSE(DecodeBase64("====").ok());
}

TEST(Base64, AgreesWithRfc4648) {
  // RFC 4648, section 10.
  EXPECT_EQ(EncodeBase64(""), "");
  EXPECT_EQ(EncodeBase64("f"), "Zg==");
  EXPECT_EQ(EncodeBase64("fo"), "Zm8=");
  EXPECT_EQ(EncodeBase64("foobar"), "Zm9vYmFy");
}

TEST(ParallelAhead, UsesInOrderWhatWasPreparedAndNeverPreparesFartherAheadThanAsked) {
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{50}}) {
    for (const std::size_t ahead : {std::size_t{1}, std::size_t{2}, std::size_t{7}}) {
      std::vector<std::size_t> slots(ahead), used;
      std::atomic<std::size_t> num_used = 0;
      std::atomic<bool> too_far = false;
      ParallelAhead(
          count,
          ahead,
          [&](std::size_t i) {
            if (i >= num_used + ahead) too_far = true;
            slots[i % ahead] = i + 1000;
          },
          [&](std::size_t i) {
            used.push_back(slots[i % ahead] - 1000);
            EXPECT_EQ(used.back(), i);
            ++num_used;
            return true;
          });
      EXPECT_EQ(used.size(), count);
      EXPECT_FALSE(too_far) << count << " ahead " << ahead;
    }
  }
}

TEST(ParallelAhead, UsesNothingAfterAStop) {
  std::atomic<int> num_prepared = 0;
  std::size_t last = 0;
  ParallelAhead(
      1000,
      4,
      [&](std::size_t) { ++num_prepared; },
      [&](std::size_t i) {
        last = i;
        return i < 10;
      });
  EXPECT_EQ(last, 10U);
  EXPECT_LE(num_prepared, 10 + 1 + 4);
}

TEST(ParallelInOrder, BeginsEveryIndexOnceAndInOrder) {
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    std::vector<std::atomic<int>> num_calls(300);
    std::atomic<std::size_t> num_begun = 0;
    std::atomic<bool> far_ahead = false;
    ParallelInOrder(num_calls.size(), [&](std::size_t i) {
      // Others may have begun between this body's number and its first line.
      if (i > num_begun++ + static_cast<std::size_t>(threads)) far_ahead = true;
      ++num_calls[i];
    });
    for (const auto& v : num_calls) EXPECT_EQ(v, 1);
    EXPECT_FALSE(far_ahead);
  }
}

TEST(ParallelFor, VisitsEveryIndexOnceForAnyThreadCount) {
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    std::vector<std::atomic<int>> num_calls(1000);
    ParallelFor(num_calls.size(), [&](std::size_t i) { ++num_calls[i]; });
    for (const auto& v : num_calls) EXPECT_EQ(v, 1);
  }
}

TEST(OnOneThread, KeepsParallelLoopsOnTheCallersThread) {
  std::set<std::thread::id> threads;
  int num_calls = 0;
  OnOneThread([&] {
    ParallelFor(1000, [&](std::size_t) {
      threads.insert(std::this_thread::get_id());
      ++num_calls;
    });
  });
  EXPECT_EQ(threads, std::set<std::thread::id>{std::this_thread::get_id()});
  EXPECT_EQ(num_calls, 1000);
}

TEST(ParallelForChunks, CoversTheRangeWithoutOverlap) {
  std::vector<int> num_calls(103, 0);
  ParallelForChunks(num_calls.size(), 10, [&](std::size_t begin, std::size_t end) {
    EXPECT_LE(end - begin, 10U);
    for (std::size_t i = begin; i < end; ++i) ++num_calls[i];
  });
  EXPECT_EQ(num_calls, std::vector<int>(103, 1));
}

TEST(Random, RepeatsForEqualSeedsAndDiffersBetweenWorks) {
  Random a(7, "noise", 3);
  Random b(7, "noise", 3);
  Random c(7, "noise", 4);
  Random d(7, "light", 3);
  const auto first = a.Next();
  EXPECT_EQ(first, b.Next());
  EXPECT_NE(first, c.Next());
  EXPECT_NE(first, d.Next());
}

TEST(Random, NormalHasUnitMoments) {
  Random random(1);
  double sum = 0;
  double sum2 = 0;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.Normal();
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.02);  // 6 standard errors
  EXPECT_NEAR(sum2 / kCount, 1.0, 0.03);
}

TEST(EveryNth, ListsThinnedOneAfterAnotherAreThinnedByTheProduct) {
  std::vector<int> all(101);
  std::iota(all.begin(), all.end(), 0);
  for (const std::size_t step : {1U, 2U, 7U, 200U}) {
    EXPECT_EQ(EveryNth(EveryNth(all, step), 2), EveryNth(all, 2 * step)) << step;
    EXPECT_EQ(EveryNth(all, step).front(), 0);
  }
  EXPECT_TRUE(EveryNth(std::vector<int>(), 3).empty());
}

TEST(EvenlySpaced, ChoosesSoManyInOrderWithGapsThatDifferByNoMoreThanOne) {
  for (const std::size_t size : {0U, 1U, 9U, 100U}) {
    std::vector<int> all(size);
    std::iota(all.begin(), all.end(), 0);
    for (std::size_t count = 0; count <= size + 2; ++count) {
      std::vector<int> chosen = EvenlySpaced(all, count);
      ASSERT_EQ(chosen.size(), std::min(count, size)) << size;
      if (chosen.empty()) continue;
      EXPECT_EQ(chosen.front(), 0);
      chosen.push_back(static_cast<int>(size));
      const int least_gap = static_cast<int>(size / (chosen.size() - 1));
      for (std::size_t n = 0; n + 1 < chosen.size(); ++n) {
        EXPECT_THAT(chosen[n + 1] - chosen[n], testing::AnyOf(least_gap, least_gap + 1));
      }
    }
  }
}

TEST(NearestWord, IsSilentWhenNothingIsNear) {
  const std::vector<std::string> known = {"track.max_depth_m", "ground.max_depth_m"};
  EXPECT_EQ(NearestWord("track.maxdepth_m", known), "track.max_depth_m");
  EXPECT_EQ(NearestWord("completely.different", known), "");
}

TEST(ResultTest, HoldsValueOrError) {
  const Result<int> good = 3;
  const Result<int> bad = InvalidInput("file x: no frames");
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(*good, 3);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().message, "file x: no frames");
  EXPECT_DEATH((void)bad.value(), "no frames");
}

// `count` times from `begin_s` on, 30 a second, a little uneven as clocks have them.
std::vector<double> Ticks(int count, double begin_s) {
  Random random(static_cast<std::uint64_t>(count));
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(begin_s + k / 30.0 + random.Uniform(0, 0.004));
  return times;
}

std::vector<double> Joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(ClockSegments, BeginWhereTheClockWasSetBack) {
  const std::vector<double> first = Ticks(200, 1000);
  for (const double begin_s : {1000.0, 1003.21, 1006.6, 990.0, 0.0}) {
    std::vector<int> expected(200, 0);
    expected.resize(350, 1);
    EXPECT_EQ(ClockSegments(Joined(first, Ticks(150, begin_s))), expected) << begin_s;
  }
  // Three recordings in one, each beginning at 0.
  const std::vector<double> joined = Joined(Joined(Ticks(30, 0), Ticks(20, 0)), Ticks(40, 0));
  std::vector<int> expected(30, 0);
  expected.resize(50, 1);
  expected.resize(90, 2);
  EXPECT_EQ(ClockSegments(joined), expected);
  // A capture of a few frames.
  EXPECT_THAT(ClockSegments(std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.2, 0.3, 0.4, 0.5, 0.6}),
              testing::ElementsAre(0, 0, 0, 0, 0, 1, 1, 1, 1, 1));
}

TEST(ClockSegments, ListsThatWantOrderAloneAreOneSegment) {
  const auto is_one = [](const std::vector<double>& times) {
    return std::ranges::all_of(ClockSegments(times), [](int segment) { return segment == 0; });
  };
  EXPECT_TRUE(is_one({}));
  EXPECT_TRUE(is_one({1}));
  const std::vector<double> ticks = Ticks(300, 5);
  EXPECT_TRUE(is_one(ticks));
  std::vector<double> reversed = ticks;
  std::ranges::reverse(reversed);
  EXPECT_TRUE(is_one(reversed));
  std::vector<double> late = ticks;
  for (std::size_t k = 10; k < 290; k += 20) std::rotate(&late[k], &late[k + 1], &late[k + 4]);
  EXPECT_TRUE(is_one(late));
  std::vector<double> shuffled = ticks;
  Random random(3);
  for (std::size_t k = shuffled.size(); k > 1; --k)
    std::swap(shuffled[k - 1], shuffled[random.Index(k)]);
  EXPECT_TRUE(is_one(shuffled));
  // Parts in the wrong order leave no seam when they are sorted.
  EXPECT_TRUE(
      is_one(Joined({ticks.begin() + 120, ticks.end()}, {ticks.begin(), ticks.begin() + 120})));
  // Frame numbers sorted as text: 0, 1, 10, 100, 101, ... 11, 110, ...
  std::vector<std::string> numbers;
  for (int k = 0; k < 1000; ++k) numbers.push_back(std::to_string(k));
  std::ranges::sort(numbers);
  std::vector<double> as_text;
  for (const std::string& number : numbers) as_text.push_back(std::stod(number));
  EXPECT_TRUE(is_one(as_text));
}

// Lines written late within a recording do not hide that its clock was set back.
TEST(ClockSegments, AreFoundAmongTimesThatAreOutOfOrder) {
  std::vector<double> times = Joined(Ticks(200, 1000), Ticks(150, 1002.5));
  std::swap(times[50], times[51]);
  std::swap(times[270], times[271]);
  std::vector<int> expected(200, 0);
  expected.resize(350, 1);
  EXPECT_EQ(ClockSegments(times), expected);
}

}  // namespace
}  // namespace deepslam

#include "deepslam/loop/similar_keyframes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::loop {
namespace {

// Of a node: as the vocabulary trees of Nister and Stewenius 2006.
constexpr std::size_t kBranches = 10;
constexpr int kDepth = 4;  // up to 10^4 words
// A node of fewer descriptors has no clusters worth telling apart.
constexpr std::size_t kMinToSplit = 30;
constexpr int kClusterRounds = 6;               // of majority clustering
constexpr std::size_t kMembersPerChunk = 1024;  // members in work at a time
constexpr std::size_t kMaxSamples = 50000;      // descriptors the tree is made of
constexpr double kCommonWord = 0.2;             // share of the keyframes
constexpr std::size_t kAlwaysKept = 50;         // keyframes: below, no word is too common
constexpr std::size_t kNeighbourhood = 3;       // entries: of these only the best is a candidate

// Whether more than half of the members have a bit, for all bits at once: `planes[p]` holds the
// p-th binary digit of the 256 counts.
DEEPSLAM_WIDE_VECTORS
BinaryDescriptor Majority(std::span<const BinaryDescriptor> samples,
                          std::span<const std::size_t> members) {
  constexpr std::size_t kWords = std::tuple_size_v<BinaryDescriptor>;
  const auto num_planes = static_cast<std::size_t>(std::bit_width(members.size()));
  std::array<BinaryDescriptor, std::numeric_limits<std::size_t>::digits> planes{};
  for (std::size_t n = 0; n < members.size(); n += 2) {  // two members, then their carry
    const BinaryDescriptor& a = samples[members[n]];
    const BinaryDescriptor b =
        n + 1 < members.size() ? samples[members[n + 1]] : BinaryDescriptor{};
    BinaryDescriptor carry;
    for (std::size_t w = 0; w < kWords; ++w) {
      const std::uint64_t unequal = a[w] ^ b[w];
      carry[w] = (a[w] & b[w]) | (unequal & planes[0][w]);
      planes[0][w] ^= unequal;
    }
    for (std::size_t p = 1; p < num_planes; ++p) {
      for (std::size_t w = 0; w < kWords; ++w) {
        const std::uint64_t sum = planes[p][w] ^ carry[w];
        carry[w] &= planes[p][w];
        planes[p][w] = sum;
      }
    }
  }
  const std::size_t half = members.size() / 2;
  BinaryDescriptor more{};
  BinaryDescriptor equal;
  equal.fill(~std::uint64_t{0});
  for (std::size_t p = num_planes; p-- > 0;) {
    const std::uint64_t digit = 0 - static_cast<std::uint64_t>((half >> p) & 1U);
    for (std::size_t w = 0; w < kWords; ++w) {
      more[w] |= equal[w] & planes[p][w] & ~digit;
      equal[w] &= ~(planes[p][w] ^ digit);
    }
  }
  return more;
}

// Of each member the nearest centre, the first of several.
DEEPSLAM_WIDE_VECTORS
void FindNearest(std::span<const BinaryDescriptor> samples,
                 std::span<const std::size_t> members,
                 std::span<const BinaryDescriptor> centres,
                 std::span<std::size_t> nearest) {
  for (std::size_t n = 0; n < members.size(); ++n) {
    const BinaryDescriptor& sample = samples[members[n]];
    int least = std::numeric_limits<int>::max();
    for (std::size_t k = 0; k < centres.size(); ++k) {
      const int distance = Distance(sample, centres[k]);
      if (distance >= least) continue;
      least = distance;
      nearest[n] = k;
    }
  }
}

class WordTree {
 public:
  explicit WordTree(std::span<const BinaryDescriptor> samples) : samples_(samples) {
    std::vector<std::size_t> all(samples.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
    nodes_.push_back({});
    Split(0, all, 0);
    samples_ = {};
  }

  [[nodiscard]] int Word(const BinaryDescriptor& descriptor) const {
    std::size_t node = 0;
    while (!nodes_[node].children.empty()) {
      int best = std::numeric_limits<int>::max();
      std::size_t next = 0;
      for (const std::size_t child : nodes_[node].children) {
        const int distance = Distance(descriptor, nodes_[child].centre);
        if (distance < best) {
          best = distance;
          next = child;
        }
      }
      node = next;
    }
    return nodes_[node].word;
  }
  [[nodiscard]] int num_words() const { return num_words_; }

 private:
  struct Node {
    BinaryDescriptor centre{};
    std::vector<std::size_t> children;
    int word = -1;  // of a leaf
  };
  using Members = std::vector<std::size_t>;
  struct Clusters {
    std::vector<Members> members;
    std::vector<BinaryDescriptor> centres;  // one each
  };

  void Split(std::size_t node, const Members& members, int depth) {
    if (depth == kDepth || members.size() < kMinToSplit) {
      nodes_[node].word = num_words_++;
      return;
    }
    const Clusters clusters = Cluster(members, node);
    if (clusters.members.size() < 2) {
      nodes_[node].word = num_words_++;
      return;
    }
    for (std::size_t k = 0; k < clusters.members.size(); ++k) {
      const std::size_t child = nodes_.size();
      nodes_.push_back({clusters.centres[k], {}, -1});
      nodes_[node].children.push_back(child);
      Split(child, clusters.members[k], depth + 1);
    }
  }

  // Majority clustering, the binary k-means; clusters without members are left out.
  [[nodiscard]] Clusters Cluster(const Members& members, std::size_t node) const {
    Clusters found;
    found.centres = DrawCentres(members, node);
    for (int round = 0; round < kClusterRounds; ++round) {
      std::vector<Members> clusters = Assign(members, found.centres);
      if (clusters == found.members) break;  // and so they would stay
      found.members = std::move(clusters);
      found.centres.resize(found.members.size());
      ForEach(members.size(), found.members.size(), [&](std::size_t k) {
        found.centres[k] = Majority(samples_, found.members[k]);
      });
    }
    return found;
  }

  // Different ones among the members.
  [[nodiscard]] std::vector<BinaryDescriptor> DrawCentres(const Members& members,
                                                          std::size_t node) const {
    Random random(0, "word tree", node);
    std::vector<BinaryDescriptor> centres;
    for (std::size_t k = 0; k < kBranches; ++k) {
      const BinaryDescriptor& drawn = samples_[members[random.Index(members.size())]];
      if (std::find(centres.begin(), centres.end(), drawn) == centres.end())
        centres.push_back(drawn);
    }
    return centres;
  }

  [[nodiscard]] std::vector<Members> Assign(const Members& members,
                                            const std::vector<BinaryDescriptor>& centres) const {
    std::vector<std::size_t> nearest(members.size());
    const std::size_t num_chunks = (members.size() + kMembersPerChunk - 1) / kMembersPerChunk;
    ForEach(members.size(), num_chunks, [&](std::size_t chunk) {
      const std::size_t begin = chunk * kMembersPerChunk;
      const std::size_t count = std::min(kMembersPerChunk, members.size() - begin);
      FindNearest(samples_,
                  std::span(members).subspan(begin, count),
                  centres,
                  std::span(nearest).subspan(begin, count));
    });
    std::vector<Members> clusters(centres.size());
    for (std::size_t n = 0; n < members.size(); ++n) clusters[nearest[n]].push_back(members[n]);
    std::erase_if(clusters, [](const Members& cluster) { return cluster.empty(); });
    return clusters;
  }

  // Side by side where there are members enough to be worth it.
  template <typename Body>
  static void ForEach(std::size_t num_members, std::size_t count, const Body& body) {
    if (num_members > kMembersPerChunk) return ParallelFor(count, body);
    for (std::size_t k = 0; k < count; ++k) body(k);
  }

  std::span<const BinaryDescriptor> samples_;
  std::vector<Node> nodes_;
  int num_words_ = 0;
};

// Evenly over the keyframes.
std::vector<BinaryDescriptor> Samples(std::span<const KeyframeFeatures> features) {
  std::size_t total = 0;
  for (const KeyframeFeatures& keyframe : features) total += keyframe.descriptors.size();
  const std::size_t step = total / kMaxSamples + 1;
  std::vector<BinaryDescriptor> samples;
  std::size_t count = 0;
  for (const KeyframeFeatures& keyframe : features) {
    for (const BinaryDescriptor& descriptor : keyframe.descriptors) {
      if (count++ % step == 0) samples.push_back(descriptor);
    }
  }
  return samples;
}

struct WordWeight {
  int word = 0;
  double weight = 0;
};
using Bag = std::vector<WordWeight>;  // ascending words; weights sum to 1

std::vector<Bag> CountWords(std::span<const KeyframeFeatures> features, const WordTree& tree) {
  std::vector<Bag> bags(features.size());
  ParallelFor(features.size(), [&](std::size_t k) {
    std::vector<int> words;
    for (const BinaryDescriptor& descriptor : features[k].descriptors)
      words.push_back(tree.Word(descriptor));
    std::sort(words.begin(), words.end());
    for (const int word : words) {
      if (bags[k].empty() || bags[k].back().word != word) bags[k].push_back({word, 0});
      bags[k].back().weight += 1;
    }
  });
  return bags;
}

struct Posting {
  std::size_t index = 0;
  double weight = 0;
};
using InvertedIndex = std::vector<std::vector<Posting>>;  // by word, ascending entries

// Weighs the words by their rarity and lists who has them; words too common are dropped.
InvertedIndex WeighWords(int num_words, std::vector<Bag>& bags) {
  std::vector<std::size_t> owners(static_cast<std::size_t>(num_words));
  for (const Bag& bag : bags) {
    for (const WordWeight& entry : bag) ++owners[static_cast<std::size_t>(entry.word)];
  }
  const auto most = std::max(
      kAlwaysKept, static_cast<std::size_t>(kCommonWord * static_cast<double>(bags.size())));
  InvertedIndex lists(owners.size());
  for (std::size_t k = 0; k < bags.size(); ++k) {
    double sum = 0;
    std::erase_if(bags[k], [&](const WordWeight& entry) {
      return owners[static_cast<std::size_t>(entry.word)] > most;
    });
    for (WordWeight& entry : bags[k]) {
      const auto seen = static_cast<double>(owners[static_cast<std::size_t>(entry.word)]);
      entry.weight *= std::log(1.0 + static_cast<double>(bags.size()) / seen);
      sum += entry.weight;
    }
    for (WordWeight& entry : bags[k]) {
      entry.weight /= sum;
      lists[static_cast<std::size_t>(entry.word)].push_back({k, entry.weight});
    }
  }
  return lists;
}

// What the two share of their weights.
double Similarity(const Bag& a, const Bag& b) {
  double shared = 0;
  auto at = b.begin();
  for (const WordWeight& entry : a) {
    while (at != b.end() && at->word < entry.word) ++at;
    if (at != b.end() && at->word == entry.word) shared += std::min(entry.weight, at->weight);
  }
  return shared;
}

std::vector<SimilarKeyframe> Candidates(std::size_t query,
                                        const std::vector<Bag>& bags,
                                        const InvertedIndex& lists,
                                        const SimilarityOptions& options) {
  const auto gap = static_cast<std::size_t>(std::max(1, options.min_gap));
  if (query < gap || bags[query].empty()) return {};
  const std::size_t end = query - gap + 1;
  std::vector<double> scores(end);
  for (const WordWeight& entry : bags[query]) {
    for (const Posting& posting : lists[static_cast<std::size_t>(entry.word)]) {
      if (posting.index >= end) break;
      scores[posting.index] += std::min(entry.weight, posting.weight);
    }
  }
  const double least = options.min_relative * Similarity(bags[query], bags[query - 1]);
  std::vector<SimilarKeyframe> ranked;
  for (std::size_t k = 0; k < end; ++k) {
    if (scores[k] > 0 && scores[k] >= least) ranked.push_back({k, scores[k]});
  }
  std::stable_sort(
      ranked.begin(), ranked.end(), [](const SimilarKeyframe& a, const SimilarKeyframe& b) {
        return a.score > b.score;
      });
  std::vector<SimilarKeyframe> best;
  for (const SimilarKeyframe& candidate : ranked) {
    if (static_cast<int>(best.size()) >= options.max_candidates) break;
    const bool beside = std::any_of(best.begin(), best.end(), [&](const SimilarKeyframe& other) {
      return candidate.index <= other.index + kNeighbourhood &&
             other.index <= candidate.index + kNeighbourhood;
    });
    if (!beside) best.push_back(candidate);
  }
  return best;
}

}  // namespace

std::vector<std::vector<SimilarKeyframe>> FindSimilarKeyframes(
    std::span<const KeyframeFeatures> features, const SimilarityOptions& options) {
  std::vector<std::vector<SimilarKeyframe>> similar(features.size());
  const std::vector<BinaryDescriptor> samples = Samples(features);
  if (samples.empty()) return similar;
  const WordTree tree(samples);
  std::vector<Bag> bags = CountWords(features, tree);
  const InvertedIndex lists = WeighWords(tree.num_words(), bags);
  ParallelFor(features.size(),
              [&](std::size_t k) { similar[k] = Candidates(k, bags, lists, options); });
  return similar;
}

}  // namespace deepslam::loop

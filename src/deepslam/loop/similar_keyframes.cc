#include "deepslam/loop/similar_keyframes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"

namespace deepslam::loop {
namespace {

constexpr std::size_t kBranches = 10;
constexpr int kDepth = 4;  // up to 10^4 words
constexpr std::size_t kMinToSplit = 30;
constexpr int kRounds = 6;                  // of majority clustering
constexpr std::size_t kMaxSamples = 50000;  // descriptors the tree is made of
constexpr double kCommonWord = 0.2;         // share of the keyframes
constexpr std::size_t kAlwaysKept = 50;     // keyframes: below, no word is too common
constexpr std::size_t kNeighbourhood = 3;   // entries: of these only the best is a candidate

BinaryDescriptor Majority(std::span<const BinaryDescriptor> samples,
                          std::span<const std::size_t> members) {
  std::array<std::size_t, 256> ones{};
  for (const std::size_t m : members) {
    for (std::size_t bit = 0; bit < 256; ++bit)
      ones[bit] += (samples[m][bit / 64] >> (bit % 64)) & 1U;
  }
  BinaryDescriptor centre{};
  for (std::size_t bit = 0; bit < 256; ++bit) {
    if (2 * ones[bit] > members.size()) centre[bit / 64] |= std::uint64_t{1} << (bit % 64);
  }
  return centre;
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

  void Split(std::size_t node, const Members& members, int depth) {
    if (depth == kDepth || members.size() < kMinToSplit) {
      nodes_[node].word = num_words_++;
      return;
    }
    const std::vector<Members> clusters = Cluster(members, node);
    if (clusters.size() < 2) {
      nodes_[node].word = num_words_++;
      return;
    }
    for (const Members& cluster : clusters) {
      const std::size_t child = nodes_.size();
      nodes_.push_back({Majority(samples_, cluster), {}, -1});
      nodes_[node].children.push_back(child);
      Split(child, cluster, depth + 1);
    }
  }

  // Majority clustering, the binary k-means; clusters without members are left out.
  [[nodiscard]] std::vector<Members> Cluster(const Members& members, std::size_t node) const {
    Random random(0, "word tree", node);
    std::vector<BinaryDescriptor> centres;
    for (std::size_t k = 0; k < kBranches; ++k) {
      const BinaryDescriptor& drawn = samples_[members[random.Index(members.size())]];
      if (std::find(centres.begin(), centres.end(), drawn) == centres.end())
        centres.push_back(drawn);
    }
    std::vector<Members> clusters;
    for (int round = 0; round < kRounds; ++round) {
      clusters.assign(centres.size(), {});
      for (const std::size_t m : members) {
        std::size_t nearest = 0;
        for (std::size_t k = 1; k < centres.size(); ++k) {
          if (Distance(samples_[m], centres[k]) < Distance(samples_[m], centres[nearest]))
            nearest = k;
        }
        clusters[nearest].push_back(m);
      }
      std::erase_if(clusters, [](const Members& cluster) { return cluster.empty(); });
      centres.clear();
      for (const Members& cluster : clusters) centres.push_back(Majority(samples_, cluster));
    }
    return clusters;
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

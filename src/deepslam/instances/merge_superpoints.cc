#include "deepslam/instances/merge_superpoints.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include <Eigen/Geometry>

namespace deepslam::instances {
namespace {

// Fewer pairs of elements that touch are no contact for a consensus, a convex edge, or a small
// part.
constexpr int kMinPairsOfConsensus = 3;
constexpr int kMinPairsOfConvexEdge = 4;  // of fewer the share that is convex says nothing
constexpr int kMinPairsOfSmallPart = 2;   // fewer, as a small part has a short rim
// Slats, arms and what hides them leave gaps of this width between parts of one thing.
constexpr float kGapM = 0.12F;
// More consensus votes than this make a merge no more urgent.
constexpr double kManyVotes = 10;

// What is known of two parts: sums over the superpoints in them, votes weighted by the smaller
// superpoint's elements.
struct Link {
  double same = 0;
  double different = 0;
  double vote_weight = 0;
  double num_contacts = 0;  // of superpoints that touch or are near
  double num_pairs = 0;
  double num_convex = 0;

  Link& operator+=(const Link& other) {
    same += other.same;
    different += other.different;
    vote_weight += other.vote_weight;
    num_contacts += other.num_contacts;
    num_pairs += other.num_pairs;
    num_convex += other.num_convex;
    return *this;
  }
  [[nodiscard]] double Same() const { return vote_weight > 0 ? same / vote_weight : 0; }
  [[nodiscard]] double Different() const { return vote_weight > 0 ? different / vote_weight : 0; }
  // Views that tell them apart are as many as matter, and more than those that do not.
  [[nodiscard]] bool ToldApart(double min_votes) const {
    return Different() >= min_votes && Different() > Same();
  }
};

// Parts that merge, the most urgent pair first.
class PartGraph {
 public:
  // Nothing: not to be merged; else how urgent it is. `smaller`: elements of the smaller part.
  using Urgency = std::function<std::optional<double>(const Link& link, double smaller)>;

  PartGraph(const Superpoints& superpoints, const Contacts& contacts, const ViewVotes& votes)
      : part_of_(superpoints.num_elements.size()),
        num_elements_(superpoints.num_elements.begin(), superpoints.num_elements.end()),
        neighbours_(superpoints.num_elements.size()) {
    for (std::size_t s = 0; s < part_of_.size(); ++s) part_of_[s] = static_cast<int>(s);
    for (const auto& [pair, vote] : votes.pairs) {
      const double weight = Smaller(pair);
      Add(pair, {vote.same * weight, vote.different * weight, weight, 0, 0, 0});
    }
    for (const auto& [pair, contact] : contacts)
      Add(pair,
          {0,
           0,
           0,
           1,
           static_cast<double>(contact.num_pairs),
           static_cast<double>(contact.num_convex)});
  }

  // Merges while some pair is to be merged; of equally urgent ones the first.
  void MergeAll(const Urgency& urgency) {
    std::set<Waiting> queue;
    std::map<SuperpointPair, double> waiting;
    const auto reconsider = [&](const SuperpointPair& pair) {
      Forget(pair, queue, waiting);
      const auto link = links_.find(pair);
      if (link == links_.end()) return;
      const std::optional<double> urgent = urgency(link->second, Smaller(pair));
      if (!urgent) return;
      queue.insert({-*urgent, pair});
      waiting[pair] = -*urgent;
    };
    for (const auto& [pair, link] : links_) reconsider(pair);
    while (!queue.empty()) {
      const SuperpointPair pair = queue.begin()->second;
      const std::set<int> changed =
          Merge(pair, [&](const SuperpointPair& gone) { Forget(gone, queue, waiting); });
      const int kept = part_of_[static_cast<std::size_t>(pair.first)];
      for (const int other : changed) reconsider(std::minmax(kept, other));
    }
  }

  [[nodiscard]] std::vector<int> Numbered() const {
    std::vector<int> number_of(part_of_.size(), -1);
    std::vector<int> numbers;
    int next = 0;
    for (const int part : part_of_) {
      int& number = number_of[static_cast<std::size_t>(part)];
      if (number < 0) number = next++;
      numbers.push_back(number);
    }
    return numbers;
  }

 private:
  using Waiting = std::pair<double, SuperpointPair>;

  [[nodiscard]] double Smaller(const SuperpointPair& pair) const {
    return std::min(num_elements_[static_cast<std::size_t>(pair.first)],
                    num_elements_[static_cast<std::size_t>(pair.second)]);
  }
  void Add(const SuperpointPair& pair, const Link& link) {
    links_[pair] += link;
    neighbours_[static_cast<std::size_t>(pair.first)].insert(pair.second);
    neighbours_[static_cast<std::size_t>(pair.second)].insert(pair.first);
  }
  static void Forget(const SuperpointPair& pair,
                     std::set<Waiting>& queue,
                     std::map<SuperpointPair, double>& waiting) {
    const auto found = waiting.find(pair);
    if (found == waiting.end()) return;
    queue.erase({found->second, pair});
    waiting.erase(found);
  }
  // The second part becomes one with the first, whose neighbours are returned: all links to it are
  // new.
  std::set<int> Merge(const SuperpointPair& pair,
                      const std::function<void(const SuperpointPair&)>& gone) {
    const auto [kept, merged] = pair;
    gone(pair);
    links_.erase(pair);
    for (const int other : neighbours_[static_cast<std::size_t>(merged)]) {
      neighbours_[static_cast<std::size_t>(other)].erase(merged);
      if (other == kept) continue;
      const SuperpointPair old = std::minmax(merged, other);
      gone(old);
      const Link link = links_.at(old);
      links_.erase(old);
      Add(std::minmax(kept, other), link);
    }
    neighbours_[static_cast<std::size_t>(merged)].clear();
    num_elements_[static_cast<std::size_t>(kept)] +=
        num_elements_[static_cast<std::size_t>(merged)];
    for (int& part : part_of_) {
      if (part == merged) part = kept;
    }
    return neighbours_[static_cast<std::size_t>(kept)];
  }

  std::vector<int> part_of_;  // of each superpoint: the least superpoint of its part
  std::vector<double> num_elements_;
  std::vector<std::set<int>> neighbours_;
  std::map<SuperpointPair, Link> links_;
};

}  // namespace

void Describe(OptionsVisitor& visitor, MergeOptions& options) {
  visitor.Field("min_consensus",
                options.min_consensus,
                {0, 1},
                "1",
                "share of the views that must say that two parts are one thing");
  visitor.Field("min_votes",
                options.min_votes,
                {0, 1000},
                "views",
                "how many views that takes; as many tell parts apart");
  visitor.Field("min_consensus_apart",
                options.min_consensus_apart,
                {0, 1},
                "1",
                "the same share for parts near each other that do not touch");
  visitor.Field(
      "min_votes_apart", options.min_votes_apart, {0, 1000}, "views", "how many views that takes");
  visitor.Field(
      "min_convex_share",
      options.min_convex_share,
      {0, 1},
      "1",
      "share of a contact that is convex where parts are merged that no view tells apart");
  visitor.Field("min_contact_ratio",
                options.min_contact_ratio,
                {0, 100},
                "1",
                "length of such a contact in relation to the smaller part");
  visitor.Field("small_part_m2",
                options.small_part_m2,
                {0, 10},
                "m2",
                "parts with less surface join what they touch most");
}

Contacts FindContacts(const SurfaceElements& elements,
                      const Superpoints& superpoints,
                      std::span<const ElementPair> pairs) {
  Contacts contacts;
  for (const ElementPair& pair : pairs) {
    const int a = superpoints.of_element[static_cast<std::size_t>(pair.first)];
    const int b = superpoints.of_element[static_cast<std::size_t>(pair.second)];
    if (a < 0 || b < 0 || a == b) continue;
    Contact& contact = contacts[std::minmax(a, b)];
    ++contact.num_pairs;
    if (IsConvex(elements, pair)) ++contact.num_convex;
  }
  return contacts;
}

void AddNear(const SurfaceElements& elements, const Superpoints& superpoints, Contacts& contacts) {
  std::vector<Eigen::AlignedBox3f> boxes(static_cast<std::size_t>(superpoints.count()));
  for (std::size_t i = 0; i < superpoints.of_element.size(); ++i) {
    if (superpoints.of_element[i] >= 0)
      boxes[static_cast<std::size_t>(superpoints.of_element[i])].extend(elements.points()[i]);
  }
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = a + 1; b < boxes.size(); ++b) {
      if (boxes[a].squaredExteriorDistance(boxes[b]) < kGapM * kGapM)
        contacts.try_emplace({static_cast<int>(a), static_cast<int>(b)});
    }
  }
}

std::vector<int> MergeSuperpoints(const Superpoints& superpoints,
                                  const Contacts& contacts,
                                  const ViewVotes& votes,
                                  double voxel_m,
                                  const MergeOptions& options) {
  PartGraph parts(superpoints, contacts, votes);
  parts.MergeAll([&](const Link& link, double) -> std::optional<double> {
    const double same = link.Same();
    const bool touch = link.num_pairs >= kMinPairsOfConsensus;
    if (link.num_contacts == 0 || same < (touch ? options.min_votes : options.min_votes_apart))
      return std::nullopt;
    const double consensus = same / (same + link.Different());
    if (consensus < (touch ? options.min_consensus : options.min_consensus_apart))
      return std::nullopt;
    return consensus * std::min(same, kManyVotes);
  });
  parts.MergeAll([&](const Link& link, double smaller) -> std::optional<double> {
    if (link.num_pairs < kMinPairsOfConvexEdge || link.ToldApart(options.min_votes))
      return std::nullopt;
    const double convex_share = link.num_convex / link.num_pairs;
    const double ratio = link.num_pairs / std::sqrt(smaller);
    if (convex_share <= options.min_convex_share || ratio <= options.min_contact_ratio)
      return std::nullopt;
    return convex_share * ratio;
  });
  const double small_part = options.small_part_m2 / (voxel_m * voxel_m);
  parts.MergeAll([&](const Link& link, double smaller) -> std::optional<double> {
    if (link.num_pairs < kMinPairsOfSmallPart || smaller > small_part ||
        link.ToldApart(options.min_votes))
      return std::nullopt;
    return link.num_pairs / std::sqrt(smaller);
  });
  return parts.Numbered();
}

}  // namespace deepslam::instances

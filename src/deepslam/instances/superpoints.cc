#include "deepslam/instances/superpoints.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "deepslam/core/check.h"

namespace deepslam::instances {
namespace {

// Within these a contact counts as flat: normals of a voxel a few centimetres wide are that noisy.
constexpr double kFlatDifference = 0.1;  // 1 - cos of 26 degrees
constexpr float kConcaveSlack = 0.05F;   // along the unit vector between two elements

struct Edge {
  ElementPair pair;
  double cost = 0;
};

// Components that grow by joining, each with the largest cost that it still accepts.
class Forest {
 public:
  Forest(std::size_t num_elements, double threshold)
      : parent_(num_elements),
        num_elements_(num_elements, 1),
        max_cost_(num_elements, threshold),
        threshold_(threshold) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  [[nodiscard]] int Find(int element) {
    while (parent_[Index(element)] != element) {
      parent_[Index(element)] = parent_[Index(parent_[Index(element)])];
      element = parent_[Index(element)];
    }
    return element;
  }
  [[nodiscard]] int NumElements(int root) const { return num_elements_[Index(root)]; }
  [[nodiscard]] double MaxCost(int root) const { return max_cost_[Index(root)]; }
  void Join(int root, int other, double cost) {
    parent_[Index(other)] = root;
    num_elements_[Index(root)] += num_elements_[Index(other)];
    max_cost_[Index(root)] = cost + threshold_ / num_elements_[Index(root)];
  }

 private:
  static std::size_t Index(int element) { return static_cast<std::size_t>(element); }

  std::vector<int> parent_;
  std::vector<int> num_elements_;
  std::vector<double> max_cost_;
  double threshold_;
};

std::vector<Edge> SortedEdges(const SurfaceElements& elements,
                              std::span<const char> is_structure,
                              std::span<const ElementPair> pairs,
                              double convex_cost) {
  std::vector<Edge> edges;
  for (const ElementPair& pair : pairs) {
    if (is_structure[static_cast<std::size_t>(pair.first)] != 0 ||
        is_structure[static_cast<std::size_t>(pair.second)] != 0)
      continue;
    const double difference = NormalDifference(elements, pair);
    edges.push_back({pair, IsConvex(elements, pair) ? convex_cost * difference : difference});
  }
  std::ranges::stable_sort(edges, {}, &Edge::cost);
  return edges;
}

}  // namespace

void Describe(OptionsVisitor& visitor, SuperpointOptions& options) {
  visitor.Field("threshold",
                options.threshold,
                {0.01, 10},
                "1",
                "how much normals may differ within a superpoint; larger: larger superpoints");
  visitor.Field("convex_cost",
                options.convex_cost,
                {0, 1},
                "1",
                "what a convex edge costs of what a concave one does");
  visitor.Field("min_elements",
                options.min_elements,
                {1, 10000},
                "voxels",
                "smaller superpoints join the neighbour that is most like them");
}

double NormalDifference(const SurfaceElements& elements, const ElementPair& pair) {
  const Eigen::Vector3f& a = elements.normals()[static_cast<std::size_t>(pair.first)];
  const Eigen::Vector3f& b = elements.normals()[static_cast<std::size_t>(pair.second)];
  return std::max(0.0, 1.0 - static_cast<double>(a.dot(b)));
}

bool IsConvex(const SurfaceElements& elements, const ElementPair& pair) {
  if (NormalDifference(elements, pair) < kFlatDifference) return true;
  const auto first = static_cast<std::size_t>(pair.first);
  const auto second = static_cast<std::size_t>(pair.second);
  const Eigen::Vector3f way = (elements.points()[second] - elements.points()[first]).normalized();
  return (elements.normals()[second] - elements.normals()[first]).dot(way) > -kConcaveSlack;
}

Superpoints MakeSuperpoints(const SurfaceElements& elements,
                            std::span<const char> is_structure,
                            std::span<const ElementPair> pairs,
                            const SuperpointOptions& options) {
  DEEPSLAM_CHECK(is_structure.size() == elements.size(), "one flag per element");
  const std::vector<Edge> edges = SortedEdges(elements, is_structure, pairs, options.convex_cost);
  Forest forest(elements.size(), options.threshold);
  for (const Edge& edge : edges) {
    const int a = forest.Find(edge.pair.first);
    const int b = forest.Find(edge.pair.second);
    if (a != b && edge.cost <= forest.MaxCost(a) && edge.cost <= forest.MaxCost(b))
      forest.Join(a, b, edge.cost);
  }
  for (const Edge& edge : edges) {
    const int a = forest.Find(edge.pair.first);
    const int b = forest.Find(edge.pair.second);
    if (a != b && std::min(forest.NumElements(a), forest.NumElements(b)) < options.min_elements)
      forest.Join(a, b, edge.cost);
  }
  Superpoints superpoints;
  superpoints.of_element.assign(elements.size(), -1);
  std::vector<int> number_of_root(elements.size(), -1);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (is_structure[i] != 0) continue;
    int& number = number_of_root[static_cast<std::size_t>(forest.Find(static_cast<int>(i)))];
    if (number < 0) {
      number = superpoints.count();
      superpoints.num_elements.push_back(0);
    }
    superpoints.of_element[i] = number;
    ++superpoints.num_elements[static_cast<std::size_t>(number)];
  }
  return superpoints;
}

}  // namespace deepslam::instances

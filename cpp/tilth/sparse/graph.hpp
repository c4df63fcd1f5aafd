// SPDX-License-Identifier: BSD-3-Clause
// Graph of a square sparse matrix: its connected components, and an order of its unknowns with a
// narrow band.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tilth::sparse {

/// Neighbours of v are neighbour[start[v]], ..., neighbour[start[v + 1] - 1]. `Offset` and `Number`
/// are integers. The graph counts as undirected: the pattern must be symmetric.
template <class Offset, class Number>
class Graph {
 public:
  Graph(std::int64_t size, const Offset* start, const Number* neighbour)
      : size_(size), start_(start), neighbour_(neighbour) {}

  /// Number of the connected component of each vertex, in the order of their first vertices.
  std::vector<std::int64_t> parts() const {
    constexpr std::int64_t none = -2;
    std::vector<std::int64_t> part(size_, none), found;
    std::int64_t count = 0;
    for (std::int64_t first = 0; first < size_; ++first) {
      if (part[first] != none) continue;
      found = {first};
      visit(found, part, count++);
    }
    return part;
  }

  /// The reverse of Cuthill and McKee's order (1969): vertices in the order of their distance from
  /// an end of their part, the neighbours of each by their number of neighbours. The end is
  /// a pseudo-peripheral vertex (George and Liu 1979).
  std::vector<std::int64_t> narrow_order() const {
    std::vector<std::int64_t> order, found, end, mark(size_, 0);
    order.reserve(size_);
    std::int64_t sweep = 0;
    for (std::int64_t any = 0; any < size_; ++any) {
      while (mark[any] != done) {  // once, if the pattern is symmetric
        found = {any};
        Levels reached = visit(found, mark, ++sweep), before;
        do {
          end.assign(found.begin() + reached.last, found.end());
          found = {*std::min_element(end.begin(), end.end(), fewer())};
          before = reached;
          reached = visit(found, mark, ++sweep);
        } while (reached.count > before.count);
        visit(end, mark, done);
        order.insert(order.end(), end.begin(), end.end());
      }
    }
    std::reverse(order.begin(), order.end());
    return order;
  }

 private:
  struct Levels {
    std::int64_t count, last;  // number of levels, and start of the last one
  };

  static constexpr std::int64_t done = -1;

  auto fewer() const {
    return [this](std::int64_t a, std::int64_t b) {
      return start_[a + 1] - start_[a] < start_[b + 1] - start_[b];
    };
  }

  /// Extends `found` by a breadth-first search and marks what it finds with `own`; vertices with
  /// this mark are skipped. The neighbours of each vertex are visited by increasing degree.
  Levels visit(std::vector<std::int64_t>& found, std::vector<std::int64_t>& mark,
               std::int64_t own) const {
    for (const std::int64_t v : found) mark[v] = own;
    Levels levels{0, 0};
    for (std::size_t next = 0; next < found.size(); ++levels.count) {
      levels.last = static_cast<std::int64_t>(next);
      for (const std::size_t end = found.size(); next < end; ++next) {
        const std::int64_t v = found[next];
        const auto from = static_cast<std::ptrdiff_t>(found.size());
        for (Offset e = start_[v]; e < start_[v + 1]; ++e) {
          const std::int64_t w = neighbour_[e];
          if (mark[w] == own || mark[w] == done) continue;
          mark[w] = own;
          found.push_back(w);
        }
        std::stable_sort(found.begin() + from, found.end(), fewer());
      }
    }
    return levels;
  }

  std::int64_t size_;
  const Offset* start_;
  const Number* neighbour_;
};

}  // namespace tilth::sparse

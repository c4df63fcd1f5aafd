// SPDX-License-Identifier: BSD-3-Clause
// A law written in Python, evaluated for all points of a body in one call. A kernel runs twice:
// first the law only keeps what it is asked, then Python answers, then the law gives these answers.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "../material/point_law.hpp"
#include "checks.hpp"

namespace tilth::bind {

class PythonLaw final : public material::PointLaw {
 public:
  /// `law`: an object with the methods of `PythonLaw` in src/tilth/model/python_law.py, for
  /// `points` points with `count` state variables.
  PythonLaw(nb::object law, std::int64_t points, std::int64_t count)
      : law_(std::move(law)),
        count_(count),
        asked_(points, 0),
        row_(points, 0),
        input_(3 * points),
        plastic_(points),
        state_(count * points) {}

  void update(material::LawBatch& batch, const material::StateArrays& state) const override {
    for (int lane = 0; lane < batch.size; ++lane) {
      if (!(batch.wanted >> lane & 1u)) continue;
      const std::int64_t p = batch.point[lane];
      const double trial[3] = {batch.trial[0][lane], batch.trial[1][lane], batch.trial[2][lane]};
      if (!answered_) {
        ask(Question::update, p, trial, state.before + state.width * p);
        plastic_[p] = state.plastic_before[2 * p];
        for (int a = 0; a < 3; ++a) batch.elastic[a][lane] = trial[a];
        continue;  // the rest of the batch is zero
      }
      const double* tau = row(0, p, 3);
      const double* elastic = row(1, p, 3);
      const double* tangent = row(2, p, 9);
      const double* after = row(3, p, count_);
      if (!finite(tau, 3) || !finite(elastic, 3) || !finite(tangent, 9) || !finite(after, count_)) {
        batch.failed |= 1u << lane;
        continue;
      }
      std::copy(after, after + count_, state.after + state.width * p);
      batch.dissipated[lane] = 0.0;
      for (int a = 0; a < 3; ++a) {
        batch.dissipated[lane] += tau[a] * (trial[a] - elastic[a]);
        batch.kirchhoff[a][lane] = tau[a];
        batch.elastic[a][lane] = elastic[a];
      }
      for (int k = 0; k < 9; ++k) batch.tangent[k][lane] = tangent[k];
    }
  }

  bool initial_state(std::int64_t p, const double* tau, double* state) const override {
    if (!answered_) return ask(Question::initial_state, p, tau, nullptr);
    const double* found = row(0, p, count_);
    std::copy(found, found + count_, state);
    return finite(found, count_);
  }

  bool elastic_strain(std::int64_t p, const double* tau, const double* state,
                      double* strain) const override {
    if (!answered_) {
      std::fill(strain, strain + 3, 0.0);
      return ask(Question::elastic_strain, p, tau, state);
    }
    std::copy(row(0, p, 3), row(0, p, 3) + 3, strain);
    return finite(strain, 3);
  }

  double energy(std::int64_t p, const double* strain, const double* state) const override {
    if (answered_) return *row(0, p, 1);
    ask(Question::energy, p, strain, state);
    return 0.0;
  }

  material::ElasticModuli moduli(std::int64_t p, const double* strain,
                                 const double* state) const override {
    if (!answered_) {
      ask(Question::moduli, p, strain, state);
      return {1.0, 1.0};
    }
    return {row(0, p, 2)[0], row(0, p, 2)[1]};
  }

  /// Calls Python, with the lock of the interpreter, for the points that were asked about.
  void answer() {
    nb::gil_scoped_acquire lock;
    std::vector<std::int64_t> points;
    for (std::size_t p = 0; p < asked_.size(); ++p)
      if (asked_[p]) {
        row_[p] = static_cast<std::int64_t>(points.size());
        points.push_back(static_cast<std::int64_t>(p));
      }
    answered_ = true;
    if (points.empty()) return;
    const auto n = static_cast<std::int64_t>(points.size());
    const nb::object input = table(points, input_, 3), state = table(points, state_, count_);
    switch (question_.load()) {
      case Question::update: {
        const nb::object plastic = table(points, plastic_, 1);
        const auto results = nb::cast<nb::tuple>(law_.attr("update")(input, plastic, state));
        require(results.size() == 4, "update", "does not return four arrays");
        const std::int64_t widths[] = {3, 3, 9, count_};
        for (int i = 0; i < 4; ++i) keep(results[i], n, widths[i]);
        return;
      }
      case Question::initial_state:
        return keep(law_.attr("initial_state")(input), n, count_);
      case Question::elastic_strain:
        return keep(law_.attr("elastic_strain")(input, state), n, 3);
      case Question::energy:
        return keep(law_.attr("energy")(input, state), n, 1);
      case Question::moduli:
        return keep(law_.attr("moduli")(input, state), n, 2);
    }
  }

 private:
  enum class Question { update, initial_state, elastic_strain, energy, moduli };

  nb::object law_;
  std::int64_t count_;
  bool answered_ = false;
  mutable std::atomic<Question> question_{Question::update};  // the same in all points of a call
  mutable std::vector<char> asked_;
  std::vector<std::int64_t> row_;  // of each point in the arrays of Python
  mutable std::vector<double> input_, plastic_, state_;
  std::vector<ConstDoubles> answers_;

  bool ask(Question question, std::int64_t p, const double* input, const double* state) const {
    question_.store(question, std::memory_order_relaxed);
    asked_[p] = 1;
    std::copy(input, input + 3, input_.data() + 3 * p);
    if (state != nullptr) std::copy(state, state + count_, state_.data() + count_ * p);
    return true;
  }

  /// Rows of the points as an array (n, width).
  static nb::object table(const std::vector<std::int64_t>& points, const std::vector<double>& from,
                          std::int64_t width) {
    std::vector<double> rows;
    rows.reserve(width * points.size());
    for (const std::int64_t p : points)
      rows.insert(rows.end(), from.begin() + width * p, from.begin() + width * (p + 1));
    return nb::cast(give(std::move(rows), {points.size(), static_cast<std::size_t>(width)}));
  }

  void keep(nb::handle array, std::int64_t rows, std::int64_t width) {
    auto answer = nb::cast<ConstDoubles>(array);
    require_size(answer, rows * width, "the answer of a law in Python");
    answers_.push_back(std::move(answer));
  }

  const double* row(int answer, std::int64_t p, std::int64_t width) const {
    return answers_[answer].data() + width * row_[p];
  }

  static bool finite(const double* numbers, std::int64_t count) {
    return std::all_of(numbers, numbers + count, [](double x) { return std::isfinite(x); });
  }
};

}  // namespace tilth::bind

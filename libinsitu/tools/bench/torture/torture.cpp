#include <algorithm>
#include <array>
#include <cstring>

#include "cells/exact/contain_exact.h"
#include "commands.h"
#include "report/format.h"
#include "report/json.h"
#include "torture/methods.h"
#include "torture/truth.h"

namespace insitu::bench {

namespace torture {
namespace {

using math::Vec3d;

struct Score {
  std::int64_t lost = 0, wrong = 0, not_lowest = 0;
  double max_error = 0.0; ///< of right answers; in cell diameters

  bool right() const { return lost + wrong + not_lowest == 0; }
  void add(const Score& other) {
    lost += other.lost;
    wrong += other.wrong;
    not_lowest += other.not_lowest;
    max_error = std::max(max_error, other.max_error);
  }
  void keep_worst(const Score& other) {
    lost = std::max(lost, other.lost);
    wrong = std::max(wrong, other.wrong);
    not_lowest = std::max(not_lowest, other.not_lowest);
    max_error = std::max(max_error, other.max_error);
  }
};

/// The score of one answer.
Score score(const Case& c, const Vec3d& p, std::int64_t owner, std::int64_t cell,
            const Vec3d& parametric) {
  Score out;
  if (cell == owner) {
    out.max_error = cell < 0 ? 0.0 : mapped_error(c.mesh, cell, parametric, p);
    return out;
  }
  Vec3d x[8];
  const bool holds =
      cell >= 0 &&
      (c.mesh.gather(cell, x), cells::holds(cells::contain_exact(c.mesh.shape(cell), x, p).where));
  out.lost = cell < 0;
  out.wrong = cell >= 0 && !holds;
  out.not_lowest = holds;
  return out;
}

using ByPlace = std::array<Score, place_count>;

/// Scores a method; first: a line about its first answer that is not right.
ByPlace score(const Case& c, const std::vector<Point>& points, const Truth& truth,
              const Answers& answers, std::string& first) {
  ByPlace out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& p = points[i].at;
    const std::int64_t cell = answers.cells[i], owner = truth.owners[i];
    const Score s = score(c, p, owner, cell, answers.parametric[i]);
    out[std::size_t(points[i].place)].add(s);
    if (first.empty() && !s.right())
      first = format("point %zu, %s, of cell %d: {%a, %a, %a}: cell %lld, %lld expected", i,
                     name(points[i].place), int(points[i].made_in), p.x, p.y, p.z,
                     static_cast<long long>(cell), static_cast<long long>(owner));
  }
  return out;
}

/// Reasons that are not what exact arithmetic says of the point in its owner.
std::int64_t false_reasons(const Truth& truth, const Answers& answers) {
  using cells::Containment;
  using query::Reason;
  constexpr Containment meant[query::reason_count] = {Containment::outside, Containment::inside,
                                                      Containment::inside,  Containment::on_face,
                                                      Containment::on_edge, Containment::on_vertex};
  std::int64_t count = 0;
  for (std::size_t i = 0; i < answers.reasons.size(); ++i)
    count += meant[int(answers.reasons[i])] != truth.where[i];
  return count;
}

/// Answers must not depend on the way: counts points whose cell or coordinates differ in any bit.
std::int64_t differing(const Answers& a, const Answers& b) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.cells.size(); ++i)
    count += a.cells[i] != b.cells[i] ||
             (a.cells[i] >= 0 &&
              std::memcmp(&a.parametric[i], &b.parametric[i], sizeof(math::Vec3d)) != 0);
  return count;
}

/// Answers that are not the owner but a cell that may answer alone: the hint's, or in standard one
/// that is proven to hold the point.
std::int64_t alone(const Truth& truth, const Answers& answers, bool standard) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < answers.cells.size(); ++i) {
    const bool hint = i < answers.hints.size() && answers.cells[i] == answers.hints[i];
    const bool proven = standard && answers.reasons[i] == query::Reason::certified;
    count += answers.cells[i] != truth.owners[i] && (hint || proven);
  }
  return count;
}

class Tester {
public:
  explicit Tester(std::int64_t points) : points_(points) {}

  void run(const Case& c) {
    progress(c.name);
    const std::vector<Point> points = make_points(c.mesh, points_);
    const Truth truth = find_owners(c.mesh, points);
    const std::vector<Method> methods = answer_by_all(c, points, columns_);
    const std::int64_t gaps = c.conforming ? truth.gaps : 0,
                       overlaps = c.valid ? truth.overlaps : 0;
    if (gaps + overlaps > 0)
      fail(c, "the cells themselves",
           format("%lld points in gaps, %lld in overlaps", static_cast<long long>(gaps),
                  static_cast<long long>(overlaps)));
    Json json = {
        {"name", c.name},          {"valid", c.valid},         {"cells", c.mesh.cell_count()},
        {"points", points.size()}, {"owned", truth.owned},     {"gaps", gaps},
        {"overlaps", overlaps},    {"methods", Json::object()}};
    std::vector<Score> worst(columns_.size());
    std::vector<std::vector<Score>> worst_by_place(place_count, worst);
    totals_.resize(columns_.size());
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Method& method = methods[m];
      std::string first;
      const ByPlace places = score(c, points, truth, method.answers, first);
      Score s;
      for (const Score& place : places)
        s.add(place);
      const auto column = std::size_t(method.column);
      worst[column].keep_worst(s);
      for (std::size_t place = 0; c.valid && place < places.size(); ++place)
        worst_by_place[place][column].keep_worst(places[place]);
      const bool is_ours = method.column < 2;
      // Where cells overlap without folding, one of them may answer alone (query::Sampler).
      const std::int64_t allowed =
          is_ours && !c.conforming ? alone(truth, method.answers, method.column == 0) : 0;
      alone_ += allowed;
      if (is_ours && (s.lost + s.wrong > 0 || s.not_lowest > allowed))
        fail(c, method.name, first);
      const std::int64_t reasons = false_reasons(truth, method.answers);
      if (is_ours && s.right() && reasons > 0)
        fail(c, method.name, format("%lld false reasons", static_cast<long long>(reasons)));
      std::int64_t differ = 0;
      if (is_ours) { // the column's first method is its batch
        differ = differing(methods[std::size_t(3 * method.column)].answers, method.answers);
        if ((s.right() || method.answers.hints.empty()) && differ > 0)
          fail(c, method.name,
               format("%lld answers differ in bits from the batch's",
                      static_cast<long long>(differ)));
      }
      json["methods"][method.name] = {
          {"lost", s.lost},   {"wrong", s.wrong},         {"not_lowest", s.not_lowest},
          {"differ", differ}, {"false_reasons", reasons}, {"max_error", number(s.max_error)}};
    }
    cases_.push_back(json);
    rows_ += row(c.name + (c.valid ? "" : " !"), c.mesh.cell_count(), truth.owned, worst);
    for (std::size_t k = 0; k < worst.size(); ++k)
      totals_[k].add(worst[k]);
    by_place_.resize(place_count, std::vector<Score>(worst.size()));
    for (std::size_t place = 0; place < worst_by_place.size(); ++place)
      for (std::size_t k = 0; k < worst.size(); ++k)
        by_place_[place][k].add(worst_by_place[place][k]);
    for (std::size_t i = 0; c.valid && i < points.size(); ++i) {
      valid_[std::size_t(points[i].place)] += 1;
      valid_owned_[std::size_t(points[i].place)] += truth.owners[i] >= 0;
    }
    cells_ += c.mesh.cell_count();
    owned_ += truth.owned;
  }

  Output finish() {
    std::string text =
        format("insitu-bench torture: %lld points a case; lost / wrong / not lowest, "
               "largest mapped error in cell diameters\n\n  %-34s %6s %6s",
               static_cast<long long>(points_), "", "cells", "owned");
    for (const std::string& column : columns_)
      text += format("  %22s", column.c_str());
    text += "\n" + rows_ + row("all", cells_, owned_, totals_);
    text += format("\n  %-34s %6s %6s\n", "On the valid meshes, by place:", "points", "owned");
    for (std::size_t place = 0; place < by_place_.size(); ++place)
      text += row(name(Place(place)), valid_[place], valid_owned_[place], by_place_[place]);
    text += "\n";
    if (columns_.size() == 2)
      text += "  No peers: insitu-bench was built without VTK.\n";
    text += "  ! not a valid mesh: cells fold, overlap or have no volume.\n";
    text += format("  %lld answers are not the lowest id but a hint's cell, or in standard a cell "
                   "proven to hold the point, where cells overlap without folding.\n",
                   static_cast<long long>(alone_));
    if (failures_ > 0)
      text += format("  %lld FAILED:\n", static_cast<long long>(failures_)) + lines_;
    else
      text += "  Ours lost none, and misplaced no others.\n";
    const Json json = {{"command", "torture"}, {"failures", failures_}, {"cases", cases_}};
    return {text, json_text(json), failures_ == 0 ? 0 : 1};
  }

private:
  void fail(const Case& c, const std::string& who, const std::string& what) {
    ++failures_;
    lines_ += "  " + c.name + ", " + who + ": " + what + "\n";
  }
  static std::string row(const std::string& name, std::int64_t cells, std::int64_t owned,
                         const std::vector<Score>& scores) {
    std::string out = format("  %-34s %6lld %6lld", name.c_str(), static_cast<long long>(cells),
                             static_cast<long long>(owned));
    for (const Score& s : scores) {
      const std::string counts =
          s.right() ? "-"
                    : format("%lld/%lld/%lld", static_cast<long long>(s.lost),
                             static_cast<long long>(s.wrong), static_cast<long long>(s.not_lowest));
      out += format("  %14s %7.0e", counts.c_str(), s.max_error);
    }
    return out + "\n";
  }

  std::int64_t points_;
  std::int64_t alone_ = 0, failures_ = 0, cells_ = 0, owned_ = 0;
  std::vector<std::string> columns_;
  std::vector<Score> totals_;
  std::vector<std::vector<Score>> by_place_; ///< of valid meshes, by column
  std::array<std::int64_t, place_count> valid_{}, valid_owned_{};
  std::string rows_, lines_;
  Json cases_;
};

} // namespace
} // namespace torture

Output run_torture(const Options& o) {
  torture::Tester tester(o.points > 0 ? o.points : 2000);
  for (const torture::Case& c : torture::make_cases(5))
    tester.run(c);
  return tester.finish();
}

} // namespace insitu::bench

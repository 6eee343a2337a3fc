// Draws the fitted response of the first target with gnuplot: a map over two parameters, slices
// through the estimate for any other number. The script stays in the folder of the pictures.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>

#include "calibrate/output/calibration_result.h"
#include "calibrate/output/text_format.h"
#include "experiments/system/gnuplot.h"
#include "experiments/system/output_file.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Out = fmt::memory_buffer;

constexpr int map_cells = 80, slice_cells = 120;

// ", discrepancy ± 1.5 deg" of a target that has one.
std::string discrepancy_text(const Target& t) {
  if (!(t.discrepancy > 0)) return "";
  return fmt::format(", discrepancy ± {:.2g}{}", t.discrepancy, unit_suffix(t.unit));
}

constexpr const char* low_fidelity_title = "low fidelity, less its bias";

struct Scene {
  const Study& study;
  const CalibrationResult& result;
  const Target& target = study.targets.front();
  const ResponseModel& model = result.models->targets.front();

  Prediction predict(const VectorXd& u) const { return model.surrogate.best.predict(u); }
  double predict_mean(const VectorXd& u) const { return model.surrogate.best.predict_mean(u); }
};

// Round numbers, about eight over the range.
std::vector<double> round_levels(double low, double high) {
  const double rough = (high - low) / 8, power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double m : {1.0, 2.0, 2.5, 5.0})
    if (m * power >= rough) {
      step = m * power;
      break;
    }
  std::vector<double> all;
  for (double x = std::ceil(low / step) * step; x <= high; x += step) all.push_back(x);
  return all;
}

// Round values of a parameter inside its range, for ticks.
std::vector<double> tick_values(const Parameter& p) {
  std::vector<double> ticks;
  if (!p.logarithmic) return round_levels(p.min, p.max);
  for (int decade = static_cast<int>(std::floor(std::log10(p.min))); decade <= 18; ++decade)
    for (const double m : {1, 2, 5}) {
      const double t = m * std::pow(10, decade);
      if (t > 1.001 * p.max) return ticks;
      if (t >= 0.999 * p.min) ticks.push_back(t);
    }
  return ticks;
}

// The axis runs over the unit cube and is labeled with the parameter's values: one kind of axis
// for both scales, and gnuplot's image style requires equal cells.
void print_axis(Out& out, const char* axis, const Parameter& p) {
  std::vector<std::string> ticks;
  for (const double t : tick_values(p))
    ticks.push_back(fmt::format("\"{:.4g}\" {:.6f}", t, p.to_unit(t)));
  print(out, "set {0}label {1}\nset {0}range [0:1]\nset {0}tics ({2})\n", axis,
        encode::gnuplot(axis_label(words(p.name), p.unit)), fmt::join(ticks, ", "));
}

void print_preamble(Out& out, const Scene& s) {
  const Target& t = s.target;
  print(out,
        "set title 'Fitted '.{}.\"\\nmeasured \".{} offset 0,0.3\n"
        "set border lw 1.2 lc rgb '#444444'\nset tics scale 0.6 out nomirror\n"
        "set key below left reverse Left samplen 2.2 spacing 1.15 maxcols 2\n",
        encode::gnuplot(words(t.response.label)),
        encode::gnuplot(fmt::format("{:.4g} ± {:.2g}{}{}", t.value, t.uncertainty,
                                    unit_suffix(t.unit), discrepancy_text(t))));
}

// Runs of a point that gave no response.
int lost(const Point& p) {
  using enum JobStatus;
  return p.count(failed) + p.count(crashed) + p.count(timed_out) + p.count(out_of_memory);
}

// Where the number of each of the first `count` marks is written, unit square: above it, or on the
// first side where nothing else is; above where all are taken.
std::vector<VectorXd> label_places(const std::vector<VectorXd>& marks, std::size_t count) {
  const Eigen::Vector2d mark(0.013, 0.014), half(0.026, 0.011);  // half widths and heights
  const Eigen::Vector2d sides[] = {{0, 0.028},      {0, -0.028},     {0.042, 0},
                                   {-0.042, 0},     {0.035, 0.025},  {-0.035, 0.025},
                                   {0.035, -0.025}, {-0.035, -0.025}};
  const auto apart = [](const VectorXd& a, const VectorXd& b, const Eigen::Vector2d& reach) {
    return ((a - b).array().abs() > reach.array()).any();
  };
  std::vector<VectorXd> places;
  for (const VectorXd& own : std::span(marks).first(count)) {
    const auto is_free = [&](const Eigen::Vector2d& side) {
      const VectorXd at = own + side;
      const bool inside = ((at - Eigen::Vector2d(0.5, 0.5)).array().abs() < 0.5).all();
      return inside &&
             std::ranges::all_of(places,
                                 [&](const VectorXd& p) { return apart(at, p, 2 * half); }) &&
             std::ranges::all_of(marks,
                                 [&](const VectorXd& m) { return apart(at, m, half + mark); });
    };
    const auto* side = std::ranges::find_if(sides, is_free);
    places.emplace_back(own + (side == std::end(sides) ? sides[0] : *side));
  }
  return places;
}

// A simulated point of the fit, and what came of its runs; those of low fidelity less its bias.
struct Mark {
  VectorXd u;
  Sample sample;
  bool is_low_fidelity = false;
};
std::vector<Mark> marks_of(const Scene& s) {
  std::vector<Mark> marks;
  for (const Point& p : s.result.points) {
    Sample sample = firn::sample(p.finished(s.target.response));
    const bool low = p.is_low_fidelity(s.target.response.experiment);
    if (low) sample.mean -= s.model.surrogate.best.fidelity_bias(p.u).value;
    if (sample.count > 0 && !p.phase.starts_with("compare")) marks.push_back({p.u, sample, low});
  }
  return marks;
}

bool has_low_fidelity(const Scene& s) {
  return std::ranges::any_of(marks_of(s), &Mark::is_low_fidelity);
}

// One line per simulated point of the fit: parameters, mean, standard error.
void print_points(Out& out, const Scene& s) {
  for (const bool low : {false, true}) {
    print(out, "{} << END\n", low ? "$low" : "$points");
    for (const Mark& m : marks_of(s))
      if (m.is_low_fidelity == low)
        print(out, "{:.5f} {:.5g} {:.5g}\n", fmt::join(m.u, " "), m.sample.mean,
              s.model.noise.at(m.sample.mean) / std::sqrt(m.sample.count));
    print(out, "END\n");
  }
  print(out, "$arched << END\n");
  for (const Point& p : s.result.points)
    if (p.count(JobStatus::arched) > 0) print(out, "{:.5f}\n", fmt::join(p.u, " "));
  print(out, "END\n$lost << END\n");
  for (const Point& p : s.result.points)
    if (lost(p) > 0) print(out, "{:.5f}\n", fmt::join(p.u, " "));
  print(out, "END\n");
}

void print_place(Out& out, const Scene& s, const CheckedSet& set) {
  const VectorXd u = to_unit(s.study.parameters, set.values);
  print(out, "{:.5f} {:.5f}\n", u[0], u[1]);
}

// Levels of the contours, each where it crosses the diagonal of the map: there it is written.
void print_levels(Out& out, const Scene& s) {
  const ReachedRange& r = s.result.reach.front();
  print(out, "$levels << END\n");
  for (const double level : round_levels(r.lowest, r.highest))
    for (int i = 0; i < map_cells; ++i) {
      const VectorXd a = VectorXd::Constant(2, double(i) / map_cells);
      const VectorXd b = VectorXd::Constant(2, double(i + 1) / map_cells);
      if ((s.predict_mean(a) - level) * (s.predict_mean(b) - level) > 0) continue;
      print(out, "{:.5f} {:.5f} {:g}\n", a[0], a[1], level);
      break;
    }
  print(out, "END\n");
}

// The means of the simulated points, each where there is room for it.
void print_numbers(Out& out, const Scene& s) {
  const std::vector<Mark> marks = marks_of(s);
  std::vector<VectorXd> taken;
  taken.reserve(marks.size() + s.result.ridge.size());
  for (const Mark& mark : marks) taken.push_back(mark.u);
  for (const CheckedSet& member : s.result.ridge)
    taken.push_back(to_unit(s.study.parameters, member.values));
  const std::vector<VectorXd> places = label_places(taken, marks.size());
  print(out, "$numbers << END\n");
  for (std::size_t i = 0; i < marks.size(); ++i)
    print(out, "{:.5f} {:.1f}\n", fmt::join(places[i], " "), marks[i].sample.mean);
  print(out, "END\n");
}

void print_map_data(Out& out, const Scene& s) {
  print_numbers(out, s);
  print(out, "$map << END\n");
  for (int i = 0; i <= map_cells; ++i) {
    for (int j = 0; j <= map_cells; ++j) {
      const VectorXd u = Eigen::Vector2d(i, j) / map_cells;
      print(out, "{:.5f} {:.5f} {:.6g}\n", u[0], u[1], s.predict_mean(u));
    }
    print(out, "\n");
  }
  print(out, "END\n$answer << END\n");
  if (!s.result.best.values.empty()) print_place(out, s, s.result.best);
  print(out, "END\n$ridge << END\n");
  for (const CheckedSet& member : s.result.ridge) print_place(out, s, member);
  print(out, "END\n$compare << END\n");
  for (const CheckedSet& set : s.result.compare) print_place(out, s, set);
  print(out, "END\n");
  print_levels(out, s);
}

// Contours of $map at these levels, into the data block `name`.
void print_contours(Out& out, const char* name, const std::vector<double>& levels) {
  if (levels.empty()) return;
  print(out, "set cntrparam levels discrete {:.6g}\nset table ${}\nsplot $map\nunset table\n",
        fmt::join(levels, ", "), name);
}

std::string draw_map(const Scene& s) {
  const Target& t = s.target;
  const ReachedRange& r = s.result.reach.front();
  Out out;
  print_preamble(out, s);
  print_axis(out, "x", s.study.parameters[0]);
  print_axis(out, "y", s.study.parameters[1]);
  print(out, "set cblabel {} offset 1,0\nset cbrange [{:.6g}:{:.6g}]\n",
        encode::gnuplot(axis_label(words(t.response.label), t.unit)), r.lowest, r.highest);
  for (const CheckedSet& set : s.result.compare) {
    const VectorXd u = to_unit(s.study.parameters, set.values);
    print(out,
          "set label {} at {:.5f},{:.5f} left front boxed font ',10' tc rgb '#107050' "
          "offset 1.2,0\n",
          encode::gnuplot(set.name), u[0], u[1]);
  }
  print(out, "set contour base\nunset surface\n");
  print_contours(out, "target", {t.value});
  print_contours(out, "band", {t.value - t.sd(), t.value + t.sd()});
  print_contours(out, "contours", round_levels(r.lowest, r.highest));
  print(out,
        "unset contour\nset surface\n"
        "set palette defined (0 '#f7fafc', 0.35 '#c3dcec', 0.7 '#7fb2d6', 1 '#3f7fb4')\n"
        "set style textbox opaque fillcolor rgb '#e8ffffff' noborder margins 0.4,0.4\n"
        "plot $map with image notitle, \\\n"
        " $contours with lines lc rgb '#90405060' lw 1 notitle, \\\n"
        " $levels using 1:2:3 with labels boxed font ',9' tc rgb '#405060' notitle, \\\n"
        " $band with lines lc rgb '#d1491b' lw 1.6 dt (8,5) "
        "title 'as measured ± 1 standard uncertainty', \\\n"
        " $target with lines lc rgb '#d1491b' lw 3.5 title 'as measured', \\\n"
        " $points using 1:2 with points pt 7 ps 2.1 lc rgb '#303030' notitle, \\\n"
        " $points using 1:2:3 with points pt 7 ps 1.7 lc palette notitle, \\\n"
        " 1/0 with points pt 6 ps 1.9 lc rgb '#303030' title 'simulated: mean over seeds', \\\n"
        " $numbers using 1:2:3 with labels boxed font ',10' notitle");
  if (has_low_fidelity(s))
    print(out,
          ", \\\n $low using 1:2 with points pt 5 ps 1.9 lc rgb '#303030' notitle, \\\n"
          " $low using 1:2:3 with points pt 5 ps 1.5 lc palette notitle, \\\n"
          " 1/0 with points pt 4 ps 1.7 lc rgb '#303030' title '{}'",
          low_fidelity_title);
  if (!s.result.ridge.empty())
    print(out,
          ", \\\n $ridge with points pt 7 ps 1.5 lc rgb 'white' notitle, \\\n"
          " $ridge with points pt 6 ps 1.5 lw 2.2 lc rgb '#7a1f0a' title 'equally good'");
  if (!s.result.compare.empty())
    print(out, ", \\\n $compare with points pt 13 ps 2 lc rgb '#107050' title 'compared'");
  if (s.result.arched > 0)
    print(out, ", \\\n $arched with points pt 2 ps 1.6 lw 2 lc rgb '#800080' title 'arched'");
  if (std::any_of(s.result.points.begin(), s.result.points.end(),
                  [](const Point& p) { return lost(p) > 0; }))
    print(out,
          ", \\\n $lost with points pt 1 ps 1.8 lw 2 lc rgb '#c07000' title 'failed or cut short'");
  if (!s.result.best.values.empty())
    print(out,
          ", \\\n $answer with points pt 7 ps 3.4 lc rgb 'white' notitle, \\\n"
          " $answer with points pt 3 ps 2.4 lw 3 lc rgb '#d1491b' title '{}'",
          s.result.best.run() ? "answer" : "nearest");
  print(out, "\n");
  return fmt::to_string(out);
}

void print_slice_data(Out& out, const Scene& s) {
  const std::size_t d = s.study.parameters.size();
  const VectorXd at = s.result.best.values.empty()
                          ? VectorXd(VectorXd::Constant(static_cast<Index>(d), 0.5))
                          : to_unit(s.study.parameters, s.result.best.values);
  for (std::size_t i = 0; i < d; ++i) {
    print(out, "$slice{} << END\n", i + 1);
    VectorXd u = at;
    for (int c = 0; c <= slice_cells; ++c) {
      u[static_cast<Index>(i)] = double(c) / slice_cells;
      const Prediction p = s.predict(u);
      print(out, "{:.5f} {:.6g} {:.6g}\n", u[static_cast<Index>(i)], p.mean, std::sqrt(p.variance));
    }
    print(out, "END\n");
  }
}

std::string draw_slices(const Scene& s) {
  const std::size_t d = s.study.parameters.size();
  const Target& t = s.target;
  Out out;
  print_preamble(out, s);
  print(out, "set ylabel {}\nset grid lc rgb '#dddddd'\n",
        encode::gnuplot(axis_label(words(t.response.label), t.unit)));
  if (d > 1) print(out, "set multiplot layout 1,{}\n", d);
  for (std::size_t i = 0; i < d; ++i) {
    print_axis(out, "x", s.study.parameters[i]);
    print(out,
          "plot $slice{6} using 1:({0:.6g}):({1:.6g}) with filledcurves fc rgb '#f6d9c8' "
          "title 'measured ± 1 standard uncertainty', {2:.6g} with lines lw 2 lc rgb '#d1491b' "
          "notitle, \\\n"
          " $slice{6} using 1:($2-$3):($2+$3) with filledcurves fc rgb '#802b6aa0' "
          "title 'fit ± 1 sd', \\\n"
          " $slice{6} using 1:2 with lines lw 2.5 lc rgb '#2b6aa0' notitle, \\\n"
          " $points using {3}:{4}:{5} with yerrorbars pt 7 ps 1.1 lc rgb '#303030' "
          "title 'simulated ± standard error'",
          t.value - t.sd(), t.value + t.sd(), t.value, i + 1, d + 1, d + 2, i + 1);
    if (has_low_fidelity(s))
      print(out,
            ", \\\n $low using {}:{}:{} with yerrorbars pt 4 ps 1.1 lc rgb '#707070' title '{}'",
            i + 1, d + 1, d + 2, low_fidelity_title);
    print(out, "\n");
  }
  if (d > 1) print(out, "unset multiplot\n");
  return fmt::to_string(out);
}

}  // namespace

std::string plot_fitted_response(const Study& study, const CalibrationResult& result,
                                 const std::string& directory) {
  const Scene scene{study, result};
  const std::size_t d = study.parameters.size();
  const std::filesystem::path folder(directory), script = folder / "fitted_response.gp";
  Out data;
  print_points(data, scene);
  d == 2 ? print_map_data(data, scene) : print_slice_data(data, scene);
  const std::string draw = d == 2 ? draw_map(scene) : draw_slices(scene);
  const int width = d <= 2 ? 1000 : 520 * static_cast<int>(d), height = d == 2 ? 920 : 640;
  const auto start = [&](const char* terminal, const char* picture) {
    return fmt::format(
        "set terminal {} size {},{} font 'DejaVu Sans,13' noenhanced\nset output '{}'\n", terminal,
        width, height, picture);
  };
  constexpr const char *kPng = "fitted_response.png", *kSvg = "fitted_response.svg";
  const std::string text = "set encoding utf8\n" + fmt::to_string(data) + start("pngcairo", kPng) +
                           draw + "set output\nreset\n" +
                           start("svg dynamic background 'white'", kSvg) + draw + "set output\n";
  write_own_file(script.string(), text);
  try {
    const Gnuplot gnuplot;
    gnuplot.run(text);
    for (const char* picture : {kPng, kSvg}) gnuplot.save(picture, folder / picture);
    return "";
  } catch (const WriteError&) {
    throw;
  } catch (const std::runtime_error& e) {
    return fmt::format("{}; expected the program gnuplot, version 5.4 or later; its script is {}",
                       e.what(), script.string());
  }
}

}  // namespace firn

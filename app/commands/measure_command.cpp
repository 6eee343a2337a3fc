// firn measure: responses from a results file, without simulating, or an angle from photographs.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "app/commands/commands.h"
#include "app/output/response_output.h"
#include "app/support/exit_status.h"
#include "app/support/shared_options.h"
#include "experiments/case_reader/case_from_results.h"
#include "experiments/responses/measure.h"
#include "experiments/results/results_file.h"
#include "experiments/system/gnuplot.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/text/number_text.h"
#include "firn/math.h"
#include "photo/heap_photo.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct MeasureArguments {
  std::string file;
  std::vector<std::string> photos;
  std::string setup, output, picture;
  std::vector<std::string> names;
  std::vector<std::string> requirements;
  bool json = false;
};

std::vector<Response> chosen(const std::vector<Response>& all,
                             const std::vector<std::string>& names, const std::string& file) {
  if (names.empty()) return all;
  std::vector<Response> some;
  for (const std::string& name : names) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Response& r) { return r.name == name; });
    if (found == all.end()) {
      std::string known;
      for (const Response& r : all) known += (known.empty() ? "" : ", ") + r.name;
      throw InputError(fmt::format("{}: {}: no such response; expected one of: {}", file, name,
                                   known.empty() ? "none, the case has no responses" : known));
    }
    some.push_back(*found);
  }
  return some;
}

int measure_file(const MeasureArguments& a) {
  std::vector<Requirement> requirements;
  for (const std::string& text : a.requirements) requirements.push_back(parse_requirement(text));
  const Recording recording(a.file);
  const Case c = read_case(recording);
  const std::vector<Response> all = measure(recording, c);
  const std::vector<Response> responses = chosen(all, a.names, a.file);
  const std::vector<RequirementResult> verdicts = check_requirements(requirements, all);
  if (a.json) {
    Json document = {{"results_file", a.file},
                     {"status", recording.status()},
                     {"responses", responses_json(responses)}};
    if (!verdicts.empty()) document["requirements"] = verdicts_json(verdicts);
    print_json(document);
  } else {
    if (recording.status() != "finished") {
      print_lines(stderr, "{}: status of the run: {}\n", a.file, recording.status());
    }
    print_lines(stdout, "{}{}",
                a.names.empty() ? run_responses_table(responses, c) : responses_table(responses),
                verdicts_table(verdicts));
    if (responses.empty()) print_lines(stderr, "{}: the case has no responses\n", a.file);
  }
  return all_met(verdicts) ? ExitStatus::done : ExitStatus::requirement_missed;
}

// Names of the pictures of so many heaps: FILE.png, or FILE-1.png, FILE-2.png, ...
std::vector<std::string> picture_names(const std::string& file, std::size_t heaps) {
  if (heaps == 1) return {file};
  std::vector<std::string> names;
  const fs::path path = file;
  for (std::size_t k = 1; k <= heaps; ++k) {
    fs::path name = path.parent_path() / path.stem();
    name += fmt::format("-{}", k);
    name += path.extension();
    names.push_back(name.string());
  }
  return names;
}

// Throws InputError for an output that is one of the inputs.
void keep_inputs(const std::vector<std::string>& inputs, const std::string& output) {
  for (const std::string& input : inputs) {
    std::error_code error;
    if (fs::equivalent(input, output, error))
      throw InputError(
          fmt::format("{}: is an input, too; expected another name for what is written", output));
  }
}

Json photo_json(const HeapPhotoResult& result) {
  Json heaps = Json::array();
  for (const PhotoAngle& heap : result.heaps) {
    Json slopes = Json::array();
    for (const PhotoSlope& slope : heap.slopes) {
      slopes.push_back({{"name", slope.ledge.name},
                        {"angle", slope.lines.robust_angle},
                        {"least_squares_angle", slope.lines.least_squares_angle},
                        {"roughness_uncertainty", slope.lines.robust_uncertainty},
                        {"window_coverage", slope.lines.covered},
                        {"threshold", slope.threshold},
                        {"contrast", slope.contrast},
                        {"threshold_shift", slope.threshold_shift}});
    }
    heaps.push_back({{"photo", heap.file},
                     {"sha256", heap.hash},
                     {"angle", heap.angle},
                     {"roughness_uncertainty", heap.roughness},
                     {"slopes", slopes}});
  }
  return {{"setup", result.setup.file},
          {"response", result.setup.response},
          {"unit", "deg"},
          {"angle", result.angle},
          {"uncertainty", result.uncertainty()},
          {"scatter", result.scatter()},
          {"camera_uncertainty", result.camera_uncertainty},
          {"threshold_uncertainty", result.threshold_uncertainty},
          {"systematic_uncertainty", result.systematic},
          {"corner_residual_pixels", result.corner_residual},
          {"heaps", heaps}};
}

void print_photo_table(const HeapPhotoResult& result) {
  for (const PhotoAngle& heap : result.heaps) {
    print_lines(stdout, "{}\n", heap.file);
    for (const PhotoSlope& slope : heap.slopes) {
      print_lines(stdout, "  {:<12} {:>12} deg   {:.0f} % of the window under ice\n",
                  slope.ledge.name,
                  measured_text(slope.lines.robust_angle, slope.lines.robust_uncertainty),
                  100 * slope.lines.covered);
    }
  }
  print_lines(
      stdout,
      "{}: {} deg ({} {:.2g} deg; camera {:.2g} deg, threshold {:.2g} deg, common to all)\n",
      result.setup.response, measured_text(result.angle, result.uncertainty()),
      result.heaps.size() == 1 ? "roughness of the outline" : "scatter of the heaps",
      result.scatter(), result.camera_uncertainty, result.threshold_uncertainty);
}

int measure_photos(const MeasureArguments& a) {
  std::string picture = a.picture;
  if (picture.empty() && !a.output.empty())
    picture = fs::path(a.output).replace_extension(".png").string();
  std::vector<std::string> pictures;
  if (!picture.empty()) {
    Gnuplot::check_picture(picture);
    pictures = picture_names(picture, a.photos.size());
  }
  const PhotoSetup setup = read_photo_setup(a.setup);
  std::vector<std::string> inputs = a.photos;
  inputs.push_back(a.setup);
  if (!setup.background.empty()) inputs.push_back(setup.background);
  for (const std::string& name : pictures) keep_inputs(inputs, name);
  if (!a.output.empty()) keep_inputs(inputs, a.output);

  const auto load = [&](std::size_t k) { return read_photograph(a.photos[k]); };
  const HeapPhotoResult result = measure_heap_photos(setup, a.photos.size(), load);
  if (!a.output.empty()) write_file(a.output, measurement_text(result));
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const Photograph photo = load(k);
    if (photo.hash != result.heaps[k].hash)
      throw InputError(
          fmt::format("{}: has changed in the meantime; expected it to stay", photo.file));
    draw_heap_photo(result, k, photo, pictures[k]);
  }
  if (a.json)
    print_json(photo_json(result));
  else
    print_photo_table(result);
  if (!a.output.empty()) print_lines(stderr, "measurement in {}\n", a.output);
  for (const std::string& name : pictures) print_lines(stderr, "check the picture {}\n", name);
  return ExitStatus::done;
}

int measure_response(const MeasureArguments& a) {
  if (a.photos.empty()) {
    if (a.file.empty()) throw CLI::RequiredError("RUN.h5");
    return measure_file(a);
  }
  if (a.setup.empty()) throw CLI::RequiredError("--setup");
  if (!a.file.empty())
    throw InputError(fmt::format(
        "{}: is given together with --photo; expected either a results file or photographs",
        a.file));
  return measure_photos(a);
}

}  // namespace

void add_measure_command(CLI::App& app, int& status) {
  auto arguments = std::make_shared<MeasureArguments>();
  CLI::App* command =
      app.add_subcommand("measure",
                         "Measure the responses of a results file again, or the angle of repose in "
                         "photographs");
  command->add_option("RUN.h5", arguments->file, "Results file of `firn run`")->type_name("");
  CLI::Option* photo =
      command
          ->add_option("--photo", arguments->photos,
                       "Instead of RUN.h5: a photograph of a heap, PNG or JPEG. Once for each\n"
                       "heap, by a camera that stays (docs/photo.md)")
          ->type_name("FILE")
          ->allow_extra_args(false);
  command
      ->add_option("--setup", arguments->setup,
                   "With --photo: scale, corners of the box and slopes, as TOML")
      ->type_name("SETUP.toml")
      ->needs(photo);
  command
      ->add_option("-o,--output", arguments->output,
                   "With --photo: the measurement file to write, which `firn calibrate` reads")
      ->type_name("MEASUREMENT.toml")
      ->needs(photo);
  command
      ->add_option("--picture", arguments->picture,
                   "With --photo: the photograph with outline and fitted line, .png or .svg; by\n"
                   "default the name of the measurement with .png")
      ->type_name("FILE")
      ->needs(photo);
  command
      ->add_option("--response", arguments->names,
                   "Print this response alone, in place of all (may be repeated)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->excludes(photo);
  command->add_option("--require", arguments->requirements, requirement_help)
      ->type_name("\"RESPONSE<=VALUE\"")
      ->allow_extra_args(false)
      ->excludes(photo);
  command->add_flag("--json", arguments->json, json_help);
  command->callback([arguments, &status] { status = measure_response(*arguments); });
}

}  // namespace firn

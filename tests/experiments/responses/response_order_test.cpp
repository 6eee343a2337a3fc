// The order of responses on the terminal and on pages, with random cases and members.
#include "experiments/responses/response_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "experiments/text/number_text.h"

namespace firn {
namespace {

using testing::ElementsAre;

Response scalar_response(const std::string& name, double value, const std::string& unit = "1") {
  return {name, {value}, {}, unit, "as measured", 1};
}

std::vector<std::string> names_in(const std::vector<Response>& responses) {
  std::vector<std::string> names;
  names.reserve(responses.size());
  for (const Response& r : responses) names.push_back(r.name);
  return names;
}

std::size_t position(const std::vector<Response>& responses, const std::string& name) {
  const std::vector<std::string> names = names_in(responses);
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

// A machine with parts of random names, and its responses in random order, defined and not zero.
struct RandomMachine {
  explicit RandomMachine(std::mt19937_64& random) {
    const auto some = [&](int most) { return std::uniform_int_distribution<int>(0, most)(random); };
    const auto name = [&] {
      std::string text(1, static_cast<char>('a' + some(25)));
      for (int i = 0; i < 7; ++i) text += some(6) == 0 ? ' ' : static_cast<char>('a' + some(25));
      return text + "x";
    };
    const auto add = [&](const std::string& response, const char* unit) {
      responses.push_back(
          scalar_response(response_name(response), std::exp(some(200) / 20.0 - 5), unit));
    };
    for (int i = some(3); i > 0; --i) {
      Inlet inlet;
      inlet.name = name();
      for (const char* ending : {"_batches", "_batches_released"}) add(inlet.name + ending, "1");
      c.inlets.push_back(inlet);
    }
    for (int i = some(4); i > 0; --i) {
      Sensor sensor;
      sensor.name = name();
      for (const char* ending : {"_mass", "_first_time", "_count", "_order_index", "_mass_flow"})
        add(sensor.name + ending, "1");
      responses.push_back({response_name(sensor.name + "_censored_times"),
                           {1.5, 2.5},
                           {},
                           "s",
                           "until the end",
                           1});
      c.sensors.push_back(sensor);
    }
    for (int i = some(3); i > 0; --i) {
      Measure m;
      m.name = name();
      m.kind = Measure::Kind::load;
      for (const char* ending : {"load_mean", "load_peak"}) add(m.prefix() + ending, "N");
      c.measures.push_back(m);
    }
    for (int i = some(3); i > 0; --i) {
      MotionFrame frame;
      frame.name = name();
      for (const char* ending : {"_largest_torque", "_largest_force"})
        add(frame.name + ending, "N");
      c.model.frames.push_back(frame);
    }
    if (some(1) == 1) {
      c.drained_repose = DrainedRepose{};
      for (const char* one : {"angle_of_repose_left", "angle_of_repose", "discharge_time", "t50"})
        add(one, "deg");
      responses.push_back(scalar_response("arched", some(1)));
    }
    for (const char* one : {"present_count", "present_mass", "contact_overlap_median",
                            "kinetic_energy_end", "peak_normal_force"})
      add(one, "N");
    std::ranges::shuffle(responses, random);
  }

  Case c;
  std::vector<Response> responses;
};

// Names of the responses, in the order in which they answer what the case is about.
std::vector<std::string> leading_names(const Case& c) {
  std::vector<std::string> names;
  if (c.drained_repose) names = {"angle_of_repose", "arched"};
  for (const Measure& m : c.measures) names.push_back(response_name(m.name + "_load_peak"));
  for (const Inlet& inlet : c.inlets)
    for (const char* ending : {"_batches", "_batches_released"})
      names.push_back(response_name(inlet.name + ending));
  for (const Sensor& s : c.sensors) names.push_back(response_name(s.name + "_count"));
  return names;
}

TEST(ResponseOrder, WhatTheCaseAsksForComesFirst) {
  std::mt19937_64 random(20);
  for (int round = 0; round < 300; ++round) {
    const RandomMachine machine(random);
    const std::vector<Response> ordered = in_display_order(machine.responses, machine.c);
    ASSERT_THAT(names_in(ordered), testing::UnorderedElementsAreArray(names_in(machine.responses)));
    const std::vector<std::string> leading = leading_names(machine.c);
    std::vector<std::string> first = names_in(ordered);
    ASSERT_GE(first.size(), leading.size());
    first.resize(leading.size());
    EXPECT_EQ(first, leading);
    // Bookkeeping stands behind every main result.
    const std::vector<Response> main = main_responses(machine.responses, machine.c, 1000);
    for (const char* one : {"present_mass", "contact_overlap_median", "kinetic_energy_end"})
      EXPECT_GE(position(ordered, one), main.size()) << one;
    // Main results are the begin of the order.
    for (std::size_t i = 0; i < main.size(); ++i) EXPECT_EQ(main[i].name, ordered[i].name);
    const std::vector<Response> six = main_responses(machine.responses, machine.c);
    EXPECT_EQ(six.size(), std::min<std::size_t>(6, main.size()));
    for (std::size_t i = 0; i < six.size(); ++i) EXPECT_EQ(six[i].name, main[i].name);
    // The order does not depend on the number of times that it is applied.
    EXPECT_EQ(names_in(in_display_order(ordered, machine.c)), names_in(ordered));
  }
}

// Random members become zero, rounding of a zero, undefined, rows of these, or empty.
TEST(ResponseOrder, WhatMeasuredNothingComesLast) {
  std::mt19937_64 random(21);
  int last = 0;
  for (int round = 0; round < 300; ++round) {
    RandomMachine machine(random);
    std::set<std::string> nothing;
    for (Response& r : machine.responses) {
      if (r.name == "arched" || r.name.ends_with("_censored_times")) continue;
      const int kind = std::uniform_int_distribution<int>(0, 9)(random);
      if (kind > 5) continue;
      const std::vector<double> values[] = {
          {0.0},        {resolved(1e-17, r.unit) == 0 ? 1e-17 : 0.0},
          {kUndefined}, {0.0, kUndefined, 0.0},
          {},           {kUndefined, kUndefined}};
      r.value = values[kind];
      nothing.insert(r.name);
    }
    // Of a sensor without a passage, the particles that are still to come are no result.
    for (const Sensor& s : machine.c.sensors) {
      const auto count =
          std::ranges::find(machine.responses, response_name(s.name + "_count"), &Response::name);
      if (std::ranges::all_of(count->value, [](double v) { return v == 0 || v == 1e-17; }))
        nothing.insert(response_name(s.name + "_censored_times"));
    }
    const std::vector<Response> ordered = in_display_order(machine.responses, machine.c);
    for (std::size_t i = 0; i < ordered.size(); ++i)
      EXPECT_EQ(nothing.contains(ordered[i].name), i >= ordered.size() - nothing.size())
          << ordered[i].name;
    for (const Response& r : main_responses(machine.responses, machine.c, 1000)) {
      EXPECT_FALSE(nothing.contains(r.name)) << r.name;
      EXPECT_EQ(r.value.size(), 1u);
    }
    last += static_cast<int>(nothing.size());
  }
  EXPECT_GT(last, 1000);
}

TEST(ResponseOrder, AHeapLeadsWithItsAngleAndWhetherItBridges) {
  Case c;
  c.drained_repose = DrainedRepose{};
  const std::vector<Response> responses = {scalar_response("present_count", 40),
                                           scalar_response("peak_normal_force", 2, "N"),
                                           scalar_response("t10", 0.1, "s"),
                                           scalar_response("angle_of_repose_left", 21, "deg"),
                                           scalar_response("remaining_count", 30),
                                           scalar_response("angle_of_repose", 20, "deg"),
                                           scalar_response("discharge_time", 1, "s"),
                                           scalar_response("arched", 0),
                                           scalar_response("settled", 1)};
  EXPECT_THAT(names_in(main_responses(responses, c)),
              ElementsAre("angle_of_repose", "arched", "discharge_time", "remaining_count",
                          "peak_normal_force", "present_count"));
}

// The sensor that ends a stage counts what is dispensed.
TEST(ResponseOrder, TheAwaitedSensorLeads) {
  Case c;
  for (const char* name : {"level", "outlet of a"}) {
    Sensor sensor;
    sensor.name = name;
    c.sensors.push_back(sensor);
  }
  Stage stage;
  stage.name = "dispense";
  stage.end_when = {Stage::EndEvent::passed, Stage::EndEvent::stalled};
  stage.sensor = 1;
  stage.count = 5;
  c.stages.push_back(stage);
  std::vector<Response> responses = {
      scalar_response("duration_dispense", 3, "s"), scalar_response("dispense_stalled", 0),
      scalar_response("dispense_time_to_count", 3, "s"), scalar_response("level_count", 9),
      scalar_response("outlet_of_a_count", 5)};
  EXPECT_THAT(names_in(in_display_order(responses, c)),
              ElementsAre("outlet_of_a_count", "level_count", "dispense_time_to_count",
                          "duration_dispense", "dispense_stalled"));
  responses[1].value = {1};  // a jam
  EXPECT_THAT(names_in(main_responses(responses, c, 3)),
              ElementsAre("outlet_of_a_count", "level_count", "dispense_stalled"));
}

TEST(ResponseOrder, EveryKindOfMeasureLeads) {
  const std::map<Measure::Kind, std::string> leading = {
      {Measure::Kind::slip, "slide_angle"},
      {Measure::Kind::slide, "sliding_acceleration"},
      {Measure::Kind::rebound, "restitution"},
      {Measure::Kind::heap, "heap_angle"},
      {Measure::Kind::accelerometer, "contact_force_peak"},
      {Measure::Kind::drum, "drum_angle"},
      {Measure::Kind::load, "load_peak"},
      {Measure::Kind::above, "above_count"}};
  for (const std::string name : {"", "b", "two words"}) {
    for (const auto& [kind, ending] : leading) {
      Case c;
      Measure m;
      m.kind = kind;
      m.name = name;
      c.measures.push_back(m);
      const std::string leads = m.prefix() + ending;
      const std::vector<Response> responses = {scalar_response("peak_normal_force", 3, "N"),
                                               scalar_response("present_count", 3),
                                               scalar_response(leads, 3)};
      EXPECT_EQ(main_responses(responses, c, 1).at(0).name, leads);
    }
  }
}

TEST(ResponseOrder, NoResponsesAreNone) {
  EXPECT_TRUE(in_display_order({}, Case{}).empty());
  EXPECT_TRUE(main_responses({}, Case{}).empty());
  EXPECT_TRUE(main_responses({scalar_response("settled", 1)}, Case{}).empty());
}

}  // namespace
}  // namespace firn

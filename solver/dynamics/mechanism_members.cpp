#include "solver/dynamics/mechanism_members.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>

namespace firn {
namespace {

int ground_of(const std::vector<MotionFrame>& frames, int frame) {
  for (int free = free_frame(frames, frame); free >= 0; free = free_frame(frames, frame))
    frame = frames[static_cast<std::size_t>(free)].parent;
  return frame;
}

std::string name_of_frame(const std::vector<MotionFrame>& frames, int frame) {
  return frame < 0 ? "the world"
                   : fmt::format("\"{}\"", frames[static_cast<std::size_t>(frame)].name);
}

}  // namespace

bool has_several_bounded_joints(const FreeBody& body) {
  return std::ranges::count_if(body.joints, [](const Joint& j) {
           return j.has_friction() || !j.motors.empty() || j.lower > -kUnbounded ||
                  j.upper < kUnbounded;
         }) > 1;
}

std::vector<MechanismMembers> find_mechanisms(const std::vector<MotionFrame>& frames,
                                              const std::vector<Coupling>& couplings) {
  // Each free frame with the least number of those that it is tied to.
  std::vector<int> group(frames.size());
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](int f) {
    while (group[static_cast<std::size_t>(f)] != f) f = group[static_cast<std::size_t>(f)];
    return f;
  };
  const auto tie = [&](int a, int b) {
    const int x = root(a), y = root(b);
    group[static_cast<std::size_t>(std::max(x, y))] = std::min(x, y);
  };
  std::vector<bool> tied(frames.size(), false);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (!frames[f].free) continue;
    if (has_several_bounded_joints(*frames[f].free)) tied[f] = true;
    const int above = free_frame(frames, frames[f].parent);
    if (above < 0) continue;
    tie(static_cast<int>(f), above);
    tied[f] = tied[static_cast<std::size_t>(above)] = true;
  }
  for (const Coupling& c : couplings) {
    const auto fail = [&](const std::string& what) {
      throw InputError("couplings." + c.name + ": " + what);
    };
    const int a = free_frame(frames, c.a), b = free_frame(frames, c.b);
    if (a == b && !(c.ties_joints() && a >= 0 && c.joint_a != c.joint_b))
      fail(a < 0 ? "ties nothing that a force can move; expected a free motion frame"
                 : "ties a body to itself; expected two different ones");
    const int on = ground_of(frames, a < 0 ? b : a);
    const auto is_ground = [&](int frame, int free) { return free >= 0 || frame == on; };
    if (!is_ground(c.a, a) || !is_ground(c.b, b) || ground_of(frames, b < 0 ? a : b) != on)
      fail(
          fmt::format("ties {} and {}, which do not stand on the same frame; expected parts of one "
                      "machine, or the frame that it stands on",
                      name_of_frame(frames, c.a), name_of_frame(frames, c.b)));
    if (a >= 0 && b >= 0) tie(a, b);
    tied[static_cast<std::size_t>(a >= 0 ? a : b)] = true;
    tied[static_cast<std::size_t>(b >= 0 ? b : a)] = true;
  }
  std::vector<MechanismMembers> out;
  std::vector<int> place(frames.size(), -1);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (!tied[f]) continue;
    const auto r = static_cast<std::size_t>(root(static_cast<int>(f)));
    if (place[r] < 0) {
      place[r] = static_cast<int>(out.size());
      out.emplace_back().ground = ground_of(frames, static_cast<int>(f));
    }
    MechanismMembers& members = out[static_cast<std::size_t>(place[r])];
    members.frames.push_back(static_cast<int>(f));
  }
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    const int a = free_frame(frames, couplings[c].a), b = free_frame(frames, couplings[c].b);
    const auto r = static_cast<std::size_t>(root(a < 0 ? b : a));
    out[static_cast<std::size_t>(place[r])].couplings.push_back(static_cast<int>(c));
  }
  return out;
}

}  // namespace firn

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/validation.hpp"
#include "numbers.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

// Directions with a smaller sine count as parallel: no frame can be built on them in double precision.
constexpr double kParallel = 1e-8;

constexpr double kSquare = 1e-6;   // largest dot product of a frame's vectors; a scene may give them with seven digits
constexpr double kOffLine = 1e-9;  // largest relative distance of a member from the line of its body
// Of a product of vectors; a choice: some roundings.
constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();

// Columns: the local axes in ground coordinates.
struct Frame {
  Triple origin{}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  [[nodiscard]] Triple turn(const Triple& local) const {
    return triple::add(triple::scale(local[0], x), triple::add(triple::scale(local[1], y), triple::scale(local[2], z)));
  }
  // Axes as written may not be at right angles.
  [[nodiscard]] Triple turn_back(const Triple& a) const {
    const Number volume = triple::dot(triple::cross(x, y), z);
    return triple::scale(1 / volume, {triple::dot(a, triple::cross(y, z)), triple::dot(a, triple::cross(z, x)),
                                      triple::dot(a, triple::cross(x, y))});
  }
};

bool appears_before(const std::vector<std::string>& names, std::size_t i) {
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(i);
  return std::find(names.begin(), end, names[i]) != end;
}
Triple turned_left(const Triple& a) { return {-a[1], a[0], 0}; }

}  // namespace

void Validation::check_bodies() {
  order_bodies();
  for (const std::size_t b : body_order_) {
    const Body& body = scene_.bodies()[b];
    const Where where = Where("/bodies") / body.name;
    if (body.name != "ground") {
      check_base(body, where);
    } else if (!body.origin.empty() || !body.frame.empty() || !body.base.empty()) {
      report(where, "the ground is the fixed frame itself; it has members, but no origin, frame or base");
    }
    for (const Member& point : body.points) check_triple(point.local, where / "points" / point.name, false);
    for (const Member& vector : body.vectors) check_triple(vector.local, where / "vectors" / vector.name, true);
    place_members(body, where);
  }
}

// Depth first without recursion, because a chain of bodies may be long.
void Validation::order_bodies() {
  enum class State : std::uint8_t { fresh, open, done };
  const auto& bodies = scene_.bodies();
  std::vector<std::vector<std::size_t>> owners(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto add = [&](const std::string& name) {
      const Symbol* symbol = symbols_.find(name);
      if (symbol != nullptr && symbol->is_derived()) owners[b].push_back(static_cast<std::size_t>(symbol->body));
    };
    add(bodies[b].origin);
    for (const std::string& name : bodies[b].frame) add(name);
    for (const std::string& name : bodies[b].base) add(name);
  }
  std::vector<State> state(bodies.size(), State::fresh);
  std::vector<std::size_t> next(bodies.size(), 0), path;
  for (std::size_t start = 0; start < bodies.size(); ++start) {
    if (state[start] != State::fresh) continue;
    path = {start};
    state[start] = State::open;
    while (!path.empty()) {
      const std::size_t b = path.back();
      if (next[b] == owners[b].size()) {
        state[b] = State::done;
        body_order_.push_back(b);
        path.pop_back();
        continue;
      }
      const std::size_t owner = owners[b][next[b]++];
      if (state[owner] == State::fresh) {
        state[owner] = State::open;
        path.push_back(owner);
      } else if (state[owner] == State::open) {
        std::string circle;
        for (auto i = std::find(path.begin(), path.end(), owner); i != path.end(); ++i)
          circle += bodies[*i].name + " -> ";
        report(Where("/bodies") / bodies[owner].name,
               "bodies are built on each other's members in a circle: " + circle + bodies[owner].name);
        for (auto i = std::find(path.begin(), path.end(), owner); i != path.end(); ++i) {
          if (Symbol* symbol = symbols_.find(bodies[*i].name)) symbol->broken = true;
        }
      }
    }
  }
}

Triple Validation::base_direction(const Body& body, std::size_t i) const {
  const Symbol* entry = symbols_.find(body.base[i]);
  return entry->kind == NameKind::vector ? entry->at : triple::subtract(entry->at, symbols_.find(body.base[0])->at);
}

void Validation::check_base(const Body& body, const Where& where) {
  const std::string shapes =
      dimension() == 3
          ? "an origin with a frame of three vectors, a base of a point and two points or vectors, or an origin alone"
          : "a base of a point and a point or vector, an origin with a frame of one vector, or an origin alone";
  if (body.origin.empty() && body.frame.empty() && body.base.empty()) {
    report(where, "a body needs joints, or " + shapes);
  } else if (!body.base.empty() && (!body.origin.empty() || !body.frame.empty())) {
    report(where, "a body has either a base or an origin, not both: " + shapes);
  } else if (!body.base.empty()) {
    const std::size_t most = dimension() == 3 ? 3 : 2;
    if (body.base.size() < 2 || body.base.size() > most) {
      report(where / "base",
             std::string("a base has a point and ") +
                 (most == 2 ? "another point or a vector in 2D" : "one or two points or vectors in 3D") + ", not " +
                 std::to_string(body.base.size()) + " entries");
    }
    std::vector<Involved> entries;
    for (std::size_t i = 0; i < body.base.size(); ++i) {
      const Where here = where / "base" / i;
      entries.push_back(i == 0 ? point(body.base[i], here) : point_or_vector(body.base[i], here));
      if (!appears_before(body.base, i)) continue;
      report(here, in_quotes(body.base[i]) + " is in this base already; all its entries must differ");
      entries.back().usable = false;
    }
    if (body.base.size() < 2 || body.base.size() > most) return;
    if (!std::all_of(entries.begin(), entries.end(), [](const Involved& p) { return p.usable; })) return;
    const Triple along = base_direction(body, 1);
    const Number length = triple::norm(along);
    if (length == 0) {
      report(where / "base", in_quotes(body.base[0]) + " and " + in_quotes(body.base[1]) +
                                 " are at the same place; a base needs different points");
    } else if (body.base.size() == 3) {
      const Triple third = base_direction(body, 2);
      const Number area = triple::norm(triple::cross(along, third));
      if (!(area > kParallel * length * triple::norm(third)) && isfinite(area)) {
        report(where / "base", in_quotes(body.base[0]) + ", " + in_quotes(body.base[1]) + " and " +
                                   in_quotes(body.base[2]) + " lie on one line; a base needs entries that do not");
      }
    }
  } else {
    check_frame(body, where);
  }
}

void Validation::check_frame(const Body& body, const Where& where) {
  if (body.origin.empty()) {
    report(where, "a frame needs an \"origin\", the name of a point");
  } else {
    (void)point(body.origin, where / "origin");
  }
  if (body.frame.empty()) return;  // translates
  const std::size_t wanted = dimension() == 3 ? 3 : 1;
  if (body.frame.size() != wanted) {
    report(where / "frame", dimension() == 3 ? "a frame has three vectors u, v, w = u x v"
                                             : "a frame has one vector in the plane; the other is at its left");
  }
  std::vector<Involved> axes;
  for (std::size_t i = 0; i < body.frame.size(); ++i) {
    axes.push_back(vector(body.frame[i], where / "frame" / i));
    if (appears_before(body.frame, i)) {
      report(where / "frame" / i, in_quotes(body.frame[i]) + " is in this frame already; all its vectors must differ");
      axes.back().usable = false;
    }
  }
  if (body.frame.size() == wanted && wanted == 3) check_fixed_axes(body, axes, where / "frame");
}

// No equation checks that fixed vectors are at right angles and right-handed.
void Validation::check_fixed_axes(const Body& body, const std::vector<Involved>& axes, const Where& where) {
  const auto known = [&](std::size_t i) { return axes[i].usable && axes[i].fixed && triple::norm(axes[i].at) > 0; };
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (!known(i) || !known(j)) continue;
    const Number cosine = triple::dot(triple::unit(axes[i].at), triple::unit(axes[j].at));
    if (abs(cosine) <= kSquare) continue;
    report(where, in_quotes(body.frame[i]) + " and " + in_quotes(body.frame[j]) + " have the dot product " +
                      shortest(cosine.value()) + "; the vectors of a frame must be at right angles to each other");
    return;
  }
  if (!known(0) || !known(1) || !known(2)) return;
  if (triple::dot(triple::cross(axes[0].at, axes[1].at), axes[2].at) > 0) return;
  report(where, "the frame is left-handed, so its body would be mirrored; write w = u x v");
}

// Finds where the members are in the posture as written, and whether they are fixed. If the base is broken they are NaN
// and broken.
void Validation::place_members(const Body& body, const Where& where) {
  const Symbol* self = symbols_.find(body.name);
  bool usable = self != nullptr && !self->broken && !known_.at_or_below(where.text());
  bool fixed = true;
  const auto at = [&](const std::string& name, NameKind kind) {
    const Symbol* symbol = symbols_.find(name);
    if (symbol == nullptr || symbol->broken || symbol->kind != kind) {
      usable = false;
      return Triple{kNan, kNan, kNan};
    }
    fixed = fixed && symbol->fixed;
    return symbol->at;
  };

  Frame frame;
  if (body.name != "ground") {
    if (body.base.size() >= 2) {
      frame.origin = at(body.base[0], NameKind::point);
      for (std::size_t i = 1; i < body.base.size(); ++i) {
        const Symbol* entry = symbols_.find(body.base[i]);
        (void)at(body.base[i], entry == nullptr ? NameKind::point : entry->kind);
      }
      if (usable) frame.x = triple::unit(base_direction(body, 1));
      frame.y = turned_left(frame.x);
      if (usable && dimension() == 3 && body.base.size() == 3) {
        frame.z = triple::unit(triple::cross(frame.x, base_direction(body, 2)));
        frame.y = triple::cross(frame.z, frame.x);
      }
    } else {
      frame.origin = at(body.origin, NameKind::point);
      if (!body.frame.empty()) frame.x = triple::unit(at(body.frame[0], NameKind::vector));
      if (!body.frame.empty()) frame.y = turned_left(frame.x);
      if (body.frame.size() == 3) {
        frame.y = triple::unit(at(body.frame[1], NameKind::vector));
        frame.z = triple::unit(at(body.frame[2], NameKind::vector));
      }
    }
  }
  // A base of two entries in space: the body may turn about the line through them.
  const bool is_line = dimension() == 3 && body.base.size() == 2;
  // A body with only an origin does not turn vectors.
  const bool turns = !body.frame.empty() || !body.base.empty();
  const auto place = [&](const Member& member, bool is_point) {
    Symbol* symbol = symbols_.find(member.name);
    if (symbol == nullptr || !symbol->is_derived()) return;
    Triple local = member.local;
    if (member.in_ground && is_point) local = triple::subtract(local, frame.origin);
    if (is_line) {
      const Number along = member.in_ground ? triple::dot(local, frame.x) : local[0];
      const Triple off =
          member.in_ground ? triple::subtract(local, triple::scale(along, frame.x)) : Triple{0, local[1], local[2]};
      // Near the first point of the base, only rounding of the coordinates is left.
      const Number rounding = is_point ? std::max(triple::norm(member.local), triple::norm(frame.origin)) : Number(1);
      if (usable && triple::norm(off) > kOffLine * triple::norm(local) + kRounding * rounding) {
        report(where / (is_point ? "points" : "vectors") / member.name,
               "the member is off the line through " + in_quotes(body.base[0]) +
                   (symbols_.find(body.base[1])->kind == NameKind::point ? " and " : " along ") +
                   in_quotes(body.base[1]) + ", about which nothing holds the body; place it on the line, or add " +
                   "a third entry to the base");
      }
      local = {along, 0, 0};
    } else if (member.in_ground) {
      local = frame.turn_back(local);
      // Local coordinates that should be 0 are only nearly 0 after this rotation; they are set to 0, so that the member
      // does not depend on further axes of its body.
      const Number size = is_point ? std::max(triple::norm(member.local), triple::norm(frame.origin)) : Number(1);
      for (Number& c : local) {
        if (abs(c) <= kRounding * size) c = 0;
      }
    }
    if (member.in_ground) local_[member.name] = local;
    if (member.in_ground && usable && !triple::is_finite(local) && triple::is_finite(member.local)) {
      report(where / (is_point ? "points" : "vectors") / member.name,
             "the axes of its body lie in a plane as written, so that ground coordinates do not define the member; "
             "write w = u x v");
    }
    const Triple turned = frame.turn(local);
    symbol->at = is_point ? triple::add(frame.origin, turned) : triple::unit(turned);
    symbol->fixed = fixed || (!is_point && !turns);
    symbol->broken = symbol->broken || !usable || !triple::is_finite(symbol->at);
  };
  for (const Member& point : body.points) place(point, true);
  for (const Member& vector : body.vectors) place(vector, false);
}

}  // namespace assur

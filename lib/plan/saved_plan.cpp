#include "assur/saved_plan.hpp"

#include <algorithm>
#include <istream>
#include <ostream>
#include <variant>

#include "index.hpp"
#include "overloaded.hpp"
#include "parallel/machine.hpp"
#include "plan/check_plan.hpp"
#include "plan/plan_fields.hpp"
#include "scene/law_sum.hpp"

namespace assur {
namespace {

enum class LawPart : std::uint8_t { polynomial, harmonics, table };

// Refuses functions, which no file can hold; gears are numbers.
void refuse_functions(const System& system) {
  const auto refuse = [](const std::string& what, const std::string& instead) {
    throw Error(Error::Kind::input, what + ", which cannot be saved; " + instead);
  };
  for (const Equation& e : system.equations) {
    if (e.callback < 0 || numbers_of(*system.callbacks[static_cast<std::size_t>(e.callback)].callback)) continue;
    refuse("constraint '" + system.sources[static_cast<std::size_t>(e.source)].name + "' is a C++ function",
           "prepare the scene in the program that runs it");
  }
  for (const DriverInput& in : system.inputs) {
    for (const Law& law : in.laws) {
      for (const Law::Part& part : law.parts()) {
        if (!std::holds_alternative<Law::Function>(part)) continue;
        refuse("the law of driver '" + system.drivers[static_cast<std::size_t>(in.driver)] + "' is a C++ function",
               "make it a table, or a constant for a driver that the program controls");
      }
    }
  }
}

std::vector<SavedGear> gears_of(const System& system) {
  std::vector<SavedGear> gears;
  for (const CallbackBlock& block : system.callbacks) {
    gears.push_back({block.coordinates, block.unit, *numbers_of(*block.callback)});
  }
  return gears;
}

// A system with the callbacks of its gears, which no scene owns.
struct Loaded {
  System system;
  std::vector<Callback> callbacks;
};

void add_gears(Loaded& loaded, const std::vector<SavedGear>& gears) {
  loaded.callbacks.reserve(gears.size());
  for (const SavedGear& g : gears) {
    loaded.callbacks.push_back(gear_of(g.numbers));
    loaded.system.callbacks.push_back({&loaded.callbacks.back(), g.coordinates, g.unit, -1});
  }
  std::vector<CallbackBlock>& blocks = loaded.system.callbacks;
  for (std::size_t e = 0; e < loaded.system.equations.size(); ++e) {
    const Index gear = loaded.system.equations[e].callback;
    if (gear >= 0 && idx(gear) < blocks.size()) blocks[idx(gear)].first_equation = static_cast<Index>(e);
  }
}

void check_backends(const Plan& plan, std::span<const Backend> table) {
  std::string known;
  for (const Backend& b : table) known += (known.empty() ? "" : ", ") + std::string(b.id);
  for (const Plan::Choice& choice : plan.choices) {
    const SolverSettings& s = choice.solver;
    const auto refuse = [&](const std::string& why, const std::string& instead) {
      throw Error(Error::Kind::environment, "the plan solves " + std::to_string(choice.shape.groups) + " group(s) of " +
                                                std::to_string(choice.shape.n) + " unknowns with " + s.backend + ", " +
                                                why + "; " + instead + " make the plan without it (" +
                                                "assur plan SCENE --without " + s.backend + " --save FILE)");
    };
    const auto found = std::find_if(table.begin(), table.end(), [&](const Backend& b) { return b.id == s.backend; });
    if (found == table.end()) {
      refuse("which is not among the given solvers (" + known + ")",
             "link assur::assur and give load_plan() its backends(), or");
    }
    const std::string why_not = found->why_not(choice.shape, ThreadBudget{s.threads});
    if (!why_not.empty()) refuse("which cannot run here: " + why_not, "correct this, or");
    if (s.single && !found->single) refuse("which has no float version", "leave out +float, or");
  }
}

// Another P does not change the motion; another Q changes its last bits.
void fit_threads(Plan& plan, const std::optional<ThreadBudget>& budget) {
  std::int32_t q = 1;
  for (const Plan::Choice& choice : plan.choices) q = std::max(q, choice.solver.threads);
  if (plan.run.threads == 1 && q == 1) return;
  const std::int32_t most = budget ? budget->threads : available_budget().threads;
  if (q > most) {
    throw Error(Error::Kind::environment, "the plan takes " + std::to_string(q) +
                                              " threads within its linear algebra and the budget is " +
                                              std::to_string(most) + "; make the plan again with fewer threads");
  }
  const std::int32_t p = most / q;
  if (plan.run.threads <= p) return;
  plan.reason += (plan.reason.empty() ? "" : "; ") + std::to_string(p) + " instead of " +
                 std::to_string(plan.run.threads) + " threads, because of the budget";
  plan.run.threads = p;
  for (std::int32_t& threads : plan.level_threads) threads = std::min(threads, p);
  for (Plan::Choice& choice : plan.choices) choice.threads = std::min(choice.threads, p);
}

}  // namespace

void fields(PlanWriter& write, const Law& law) {
  write(law.parts().size());
  const Overloaded write_part{
      [&](const Law::Polynomial& p) { write(LawPart::polynomial, p.coefficients); },
      [&](const Law::Harmonics& h) { write(LawPart::harmonics, h.offset, h.terms); },
      [&](const Law::Spline& s) { write(LawPart::table, s.periodic, s.monotone, s.time, s.value); },
      [](const Law::Function&) {},  // save_plan() has refused it
  };
  for (const Law::Part& part : law.parts()) std::visit(write_part, part);
}

// The spline of a table is computed again from its points.
void fields(PlanReader& read, Law& law) {
  std::int32_t parts = 0;
  read(parts);
  std::vector<Law> laws;
  for (; parts > 0; --parts) {
    LawPart kind{};
    read(kind);
    if (kind == LawPart::polynomial) {
      std::vector<Number> coefficients;
      read(coefficients);
      laws.push_back(Law::polynomial(std::move(coefficients)));
    } else if (kind == LawPart::harmonics) {
      double offset = 0;
      std::vector<Harmonic> terms;
      read(offset, terms);
      laws.push_back(Law::harmonics(std::move(terms), offset));
    } else if (kind == LawPart::table) {
      bool periodic = false, monotone = false;
      std::vector<double> time, value;
      read(periodic, monotone, time, value);
      laws.push_back(Law::table(std::move(time), std::move(value), periodic, monotone));
    } else {
      read.refuse("a polynomial, harmonics or a table was expected here");
    }
  }
  law = sum_of(laws);
}

void save_plan(std::ostream& out, const Prepared& of) {
  const Preparation& prepared = preparation(of);
  refuse_functions(*prepared.structure->system);
  PlanWriter write;
  const System& system = *prepared.structure->system;
  const std::vector<SavedGear> gears = gears_of(system);
  fields(write, prepared, system, gears, *prepared.structure);
  out << write.finish() << std::flush;
  if (!out) throw Error(Error::Kind::environment, "the plan could not be written: is the disk full?");
}

Prepared load_plan(std::istream& in, const LoadOptions& options) {
  if (options.budget && options.budget->threads < 1) {
    throw Error(Error::Kind::input,
                "a budget needs at least one thread, not " + std::to_string(options.budget->threads));
  }
  PlanReader read(text_of_plan(in));
  Preparation prepared;
  const auto loaded = std::make_shared<Loaded>();
  std::vector<SavedGear> gears;
  auto structure = std::make_shared<GroupedSystem>();
  GroupedSystem& own = *structure;
  fields(read, prepared, loaded->system, gears, own);
  read.finish();
  loaded->system.index_names();
  add_gears(*loaded, gears);
  structure->system = std::shared_ptr<const System>(loaded, &loaded->system);
  prepared.structure = std::move(structure);
  check_plan(prepared);
  check_backends(prepared.plan, options.table);
  fit_threads(prepared.plan, options.budget);
  prepared.table = options.table;
  return Preparation::shared(std::move(prepared));
}

}  // namespace assur

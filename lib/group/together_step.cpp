// Compiled once for each SIMD target; make_together_step() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "group/together_step.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "group/together_step.hpp"

#include "group/pack_source-inl.hpp"
#include "group/small_algebra-inl.hpp"
#include "program/distance_equations-inl.hpp"
#include "program/separable_equations-inl.hpp"
#include "program/small_lu-inl.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "equations/separable.hpp"
#include "index.hpp"
#include "program/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

// Equations: SeparableEquations or DistanceEquations
template <int W, int N, class Equations>
class TogetherStepOf final : public TogetherStep {
  using L = Lanes<W>;
  using Source = PackSource<W>;
  using Algebra = SmallAlgebra<W, N>;
  using Column = typename Algebra::Column;
  using Matrix = typename Algebra::Matrix;

 public:
  TogetherStepOf(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                 const Separable& separable, std::span<const std::uint8_t> computed)
      : derivatives_(group_class.derivatives), reads_(blocks.reads(0)), s_(group_class, program, separable) {
    find_entries(program, separable, computed);
  }

  void place(const Places& places, std::span<const std::int32_t> columns) override {
    places_ = places;
    gains_.clear();
    for (std::size_t e = 0, part = 0; e < entries_.size(); ++part) {
      std::size_t end = e;
      while (end < entries_.size() && entries_[end].row == entries_[e].row && entries_[end].part == entries_[e].part) {
        ++end;
      }
      for (std::int32_t of = 0; of < columns[part]; ++of) {
        gains_.push_back({entries_[e].row, of, static_cast<std::int32_t>(e), static_cast<std::int32_t>(end)});
      }
      e = end;
    }
    slopes_.assign(packs_.size() * entries_.size() * W, 0.0);
    used_.assign(packs_.size() * W, 0.0);
    balls_last_.assign(packs_.size(), 0);
    numbers_.resize(packs_.size());
  }

  void begin(const double* state) override {
    if constexpr (Equations::kDistances) {
      at_rest_.resize(packs_.size() * kAtRest);
      for (std::size_t p = 0; p < packs_.size(); ++p) {
        const double* const only[3] = {state};
        s_.at_rest(Source(packs_[p].pack, only), at_rest_.data() + p * kAtRest, W);
      }
    }
  }

  Progress linearise(const double* state, int iteration, double converged, Coupling& coupling,
                     TogetherFigures& figures) override {
    Progress progress = Progress::solved;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      const TogetherPack& pack = packs_[p];
      Numbers& m = numbers_[p];
      if (iteration == 1 && !is_near(pack, coupling)) return Progress::failed;
      Column phi;
      load_unknowns(pack, state, m.x);
      const double* const only[3] = {state};
      const Source in(pack.pack, only);
      if constexpr (Equations::kDistances) {
        const double* const at_rest = at_rest_.data() + p * kAtRest;
        if (iteration == 0) {
          s_.template set_moving_inputs<true>(in, at_rest, W);
        } else {
          s_.template set_moving_inputs<false>(in, at_rest, W);
        }
      } else if (iteration == 0) {
        s_.set_inputs(in);
      } else {
        s_.template set_inputs<false>(in);
      }
      s_.evaluate(in, m.x, m.u, phi);
      if (iteration == 0) {
        for (int i = 0; i < N; ++i) {
          m.scale[i] = s_.scale_of(in, i, m.x, m.u);
          m.scale[i] = if_positive(m.scale[i], m.scale[i], L::set(1));
        }
      }
      bool solved = Algebra::at_most(phi, m.scale, converged);
      if (!solved && iteration > 0) {
        const double relative = Algebra::largest_ratio(phi, m.scale);
        if (!std::isfinite(relative)) return Progress::failed;
        const double before = Algebra::largest_ratio(m.phi, m.scale);
        if (s_.may_vanish() && iteration > 1 && falls_slowly(relative, before)) return Progress::failed;
        solved = only_rounding_is_left(relative, before);
      }
      if (!solved) {
        progress = Progress::open;
      } else if (!Algebra::at_most(phi, m.scale, figures.position)) {
        figures.position = Algebra::largest_ratio(phi, m.scale);
      }
      if (solved || iteration > 0) {
        const auto input = [&](std::int32_t i) HWY_ATTR { return s_.input(i); };
        const L used = Algebra::ball_use(pack.pack, reads_, m.x, input), before = L::load(pack.pack.ball_used.data());
        const L more = max(used - before, L::set(0));
        balls_last_[p] = less_equal(used + more + more, L::set(kBall)).all() ? 1 : 0;
        used.store(used_.data() + p * W);
      }
      for (int i = 0; i < N; ++i) m.phi[i] = phi[i];
      s_.differentiate(in, m.u, m.jacobian);
      const L poor = m.lu.factorize(m.jacobian, [&](std::size_t k) HWY_ATTR { return in.pivot(k); });
      if (!less_equal(poor, L::set(0)).all()) return Progress::failed;
      find_slopes(p, m, in);
      Column rhs, own;
      for (int i = 0; i < N; ++i) rhs[i] = L::set(0) - phi[i];
      m.lu.solve(rhs, own);
      store_by_place(own, coupling.own.data(), pack);
      for (int i = 0; i < N; ++i) {
        if (row_of_[i] < 0) continue;
        for (int j = 0; j < N; ++j) rhs[j] = L::set(j == i ? 1 : 0);
        m.lu.solve(rhs, own);
        store_by_place(own, coupling.columns[idx(row_of_[i])].data(), pack);
      }
    }
    return progress;
  }

  void couple(Coupling& coupling, bool with_gains) override {
    if (entries_.empty()) return;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      const TogetherPack& pack = packs_[p];
      for (std::size_t e = 0; e < entries_.size();) {
        const std::int32_t row = entries_[e].row;
        add_sources(pack, p, e, row_end_[idx(row)], coupling.own.data())
            .store(coupling.loads.data() + places_.loads + idx(row) * places_.groups + pack.place);
        e = row_end_[idx(row)];
      }
      if (!with_gains) continue;
      double* gain = coupling.gains.data() + places_.gains + pack.place;
      for (const Gain& g : gains_) {
        add_sources(pack, p, idx(g.begin), idx(g.end), coupling.columns[idx(g.of)].data()).store(gain);
        gain += places_.groups;
      }
    }
  }

  void correct(double* state, Coupling& coupling) override {
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      const TogetherPack& pack = packs_[p];
      Numbers& m = numbers_[p];
      Column change;
      complete(pack, coupling, change);
      store_by_place(change, coupling.change.data(), pack);
      for (int i = 0; i < N; ++i) m.x[i] = m.x[i] + change[i];
      store_unknowns(pack, m.x, state);
    }
  }

  void own_rates(double* const (&state)[3], Coupling& coupling) override {
    if (derivatives_ < 1) return;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      const TogetherPack& pack = packs_[p];
      Numbers& m = numbers_[p];
      Column rhs, own;
      if (pack.driven) {
        const Source in(pack.pack, state, pack.known.rows.data(), pack.known.addresses.data());
        s_.set_rates(in);
        s_.velocity_rhs(in, m.x, m.u, rhs);
        m.lu.solve(rhs, own);
      } else {
        for (int i = 0; i < N; ++i) own[i] = L::set(0);
      }
      store_by_place(own, coupling.own.data(), pack);
    }
  }

  void finish_rates(double* const (&state)[3], const Coupling& coupling) override {
    if (derivatives_ < 1) return;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      Numbers& m = numbers_[p];
      complete(packs_[p], coupling, m.rate);
      store_unknowns(packs_[p], m.rate, state[1]);
    }
  }

  void own_accelerations(double* const (&state)[3], Coupling& coupling, TogetherFigures& figures) override {
    if (derivatives_ < 1) return;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      const TogetherPack& pack = packs_[p];
      Numbers& m = numbers_[p];
      Column own;
      const Source in(pack.pack, state);
      s_.set_rates(in);
      s_.velocity_rhs(in, m.x, m.u, m.rhs);
      m.norm = Algebra::norm_of(m.jacobian);
      figures.velocity = Algebra::residual(m.jacobian, m.norm, m.rate, m.rhs, figures.velocity);
      if (!std::isfinite(figures.velocity)) return;
      if (derivatives_ < 2) continue;
      s_.set_accelerations(Source(pack.pack, state, pack.known.rows.data(), pack.known.addresses.data()));
      s_.acceleration_rhs(in, m.x, m.u, m.rate, m.rhs);
      m.lu.solve(m.rhs, own);
      store_by_place(own, coupling.own.data(), pack);
    }
  }

  void finish_accelerations(double* const (&state)[3], Coupling& coupling) override {
    if (derivatives_ < 2) return;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      Column acceleration;
      complete(packs_[p], coupling, acceleration);
      store_by_place(acceleration, coupling.change.data(), packs_[p]);
      store_unknowns(packs_[p], acceleration, state[2]);
    }
  }

  void measure_accelerations(const Coupling& coupling, TogetherFigures& figures) override {
    if (derivatives_ < 2) return;
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      const TogetherPack& pack = packs_[p];
      Numbers& m = numbers_[p];
      Column acceleration;
      for (int i = 0; i < N; ++i) {
        acceleration[i] = L::load(coupling.change.data() + places_.unknowns + idx(i) * places_.groups + pack.place);
      }
      for (int i = 0; i < N; ++i) {
        if (row_of_[i] < 0) continue;
        const std::size_t row = idx(row_of_[i]);
        const std::size_t begin = row == 0 ? 0 : row_end_[row - 1];
        m.rhs[i] = m.rhs[i] + add_sources(pack, p, begin, row_end_[row], coupling.change.data());
      }
      figures.acceleration = Algebra::residual(m.jacobian, m.norm, acceleration, m.rhs, figures.acceleration);
      if (!std::isfinite(figures.acceleration)) return;
    }
  }

  [[nodiscard]] std::span<const double> balls_used() const override { return used_; }

 private:
  // Of a pack at the current posture.
  struct alignas(kLineBytes) Numbers {
    Column x, scale, phi, rate, rhs;
    Matrix u, jacobian;
    L norm;
    SmallLu<L, N> lu;
  };
  // Addend of the slope of an equation along an input: coefficient * slope * share * factor.
  struct Term {
    std::int32_t coefficient, slope, share;  // coefficients
    std::int32_t square, unknown;            // factor: 2 u_ij, x_j, or 1 (both -1)
  };

  void find_entries(const Program& program, const Separable& separable, std::span<const std::uint8_t> computed) {
    const std::int32_t one = one_coefficient(program);
    // The share of an input in a register; -1: none
    const auto share = [&](std::int32_t reg, std::int32_t input) {
      if (reg == N + input) return one;
      if (reg <= program.one()) return -1;
      const Program::Form& f = program.forms[idx(reg - program.one() - 1)];
      for (std::int32_t o = f.moving; o < f.unknowns; ++o) {
        if (program.operands[idx(o)].reg == N + input) return program.operands[idx(o)].coefficient;
      }
      return -1;
    };
    const auto or_one = [&](std::int32_t slope) { return slope == Separable::kNone ? one : slope; };
    for (int i = 0; i < N; ++i) {
      row_of_[i] = -1;
      for (std::int32_t input = 0; input < program.inputs; ++input) {
        if (computed[idx(input)] == 0) continue;
        const std::size_t before = terms_.size();
        for (int j = 0; j < N; ++j) {
          const Separable::Square& q = separable.squares[idx(i * N + j)];
          if (q.s == Separable::kNone || q.b == Separable::kNone) continue;
          if (const std::int32_t of = share(q.b, input); of >= 0) terms_.push_back({q.s, one, of, j, -1});
        }
        for (const Separable::Known& t : separable.known) {
          if (t.equation != i) continue;
          if (const std::int32_t of = share(t.reg, input); of >= 0) terms_.push_back({t.coefficient, one, of, -1, -1});
        }
        for (const Separable::Linear& t : separable.linear) {
          if (t.equation != i) continue;
          if (const std::int32_t of = share(t.reg, input); of >= 0) {
            terms_.push_back({t.coefficient, or_one(t.slope), of, -1, t.unknown});
          }
        }
        if (terms_.size() == before) continue;
        if (row_of_[i] < 0) {
          row_of_[i] = rows_++;
          equation_.push_back(i);
          row_end_.push_back(0);
        }
        entries_.push_back({row_of_[i], input, before, terms_.size()});
        row_end_.back() = entries_.size();
      }
    }
  }

  HWY_INLINE void find_slopes(std::size_t p, const Numbers& m, const Source& in) {
    double* slope = slopes_.data() + p * entries_.size() * W;
    for (const Entry& e : entries_) {
      const int i = equation_[idx(e.row)];
      L sum = L::set(0);
      for (std::size_t k = e.begin; k < e.end; ++k) {
        const Term& t = terms_[k];
        L factor = in.coefficient(t.share);
        if (!Equations::kDistances) factor = factor * in.coefficient(t.coefficient);
        if (t.square >= 0) {
          factor = (factor + factor) * m.u[i][t.square];
        } else if (t.unknown >= 0) {
          factor = factor * in.coefficient(t.slope) * m.x[t.unknown];
        }
        sum = sum + factor;
      }
      sum.store(slope);
      slope += W;
    }
  }

  // -(H d) over the entries [begin, end), with the numbers d by address.
  HWY_INLINE L add_sources(const TogetherPack& pack, std::size_t p, std::size_t begin, std::size_t end,
                           const double* numbers) const {
    L sum = L::set(0);
    const double* slope = slopes_.data() + (p * entries_.size() + begin) * W;
    for (std::size_t e = begin; e < end; ++e, slope += W) {
      sum.subtract_product(L::load(slope),
                           gather_input<W>(pack.sources.rows[e], pack.sources.addresses.data() + e * W, numbers));
    }
    return sum;
  }

  // own + sum of column * load
  HWY_INLINE void complete(const TogetherPack& pack, const Coupling& coupling, Column& out) const {
    const std::size_t at = places_.unknowns + pack.place;
    for (int i = 0; i < N; ++i) out[i] = L::load(coupling.own.data() + at + idx(i) * places_.groups);
    for (std::int32_t k = 0; k < rows_; ++k) {
      const L load = L::load(coupling.loads.data() + places_.loads + idx(k) * places_.groups + pack.place);
      const double* column = coupling.columns[idx(k)].data() + at;
      for (int i = 0; i < N; ++i) out[i].add_product(L::load(column + idx(i) * places_.groups), load);
    }
  }

  // The first correction, also that of the inputs, must be small compared with the rest of the ball.
  HWY_INLINE bool is_near(const TogetherPack& pack, const Coupling& coupling) const {
    L largest = L::set(0), poison = L::set(0);
    const auto include = [&](const L& change) {
      largest = max(largest, abs(change));
      poison.add_product(change, L::set(0));
    };
    const double* own = coupling.change.data() + places_.unknowns + pack.place;
    for (int i = 0; i < N; ++i) include(L::load(own + idx(i) * places_.groups));
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      include(gather_input<W>(pack.sources.rows[e], pack.sources.addresses.data() + e * W, coupling.change.data()));
    }
    largest = largest + poison;
    const L used = if_positive(largest, largest * L::load(pack.pack.omega.data()), largest);
    const L limit = L::set(largest_first_correction(0)) * (L::set(1) - L::load(pack.pack.ball_used.data()));
    return less_equal(used, limit).all();
  }

  HWY_INLINE void store_by_place(const Column& from, double* to, const TogetherPack& pack) const {
    to += places_.unknowns + pack.place;
    for (int i = 0; i < N; ++i) from[i].store(to + idx(i) * places_.groups);
  }

  static constexpr InputRow::Kind kInterleaved = N == 2 ? InputRow::Kind::every_second : InputRow::Kind::every_third;

  static HWY_INLINE void load_unknowns(const TogetherPack& pack, const double* state, Column& to) {
    for (int i = 0; i < N; ++i) {
      to[i] = gather_input<W>(pack.unknowns.rows[idx(i)], pack.unknowns.addresses.data() + i * W, state);
    }
  }
  static HWY_INLINE void store_unknowns(const TogetherPack& pack, const Column& from, double* state) {
    const InputRow& row = pack.unknowns.rows[0];
    if (W > 1 && row.kind == kInterleaved) {
      double* to = state + row.address;
      for (int v = 0; v < L::kVectors; ++v, to += N * L::kEach) {
        if constexpr (N == 2) {
          hn::StoreInterleaved2(from[0].v[v], from[1].v[v], typename L::D(), to);
        } else {
          hn::StoreInterleaved3(from[0].v[v], from[1].v[v], from[2].v[v], typename L::D(), to);
        }
      }
      return;
    }
    const std::int32_t* address = pack.unknowns.addresses.data();
    for (int i = 0; i < N; ++i, address += W) {
      double lanes[W];
      from[i].store(lanes);
      for (int l = 0; l < pack.pack.used; ++l) state[address[l]] = lanes[l];
    }
  }

  static constexpr std::size_t kAtRest = 2 * N * N * W;  // see DistanceEquations

  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates that the branch check examines
  Equations s_;
  int row_of_[N];                     // equation -> coupled row; -1: none
  std::vector<int> equation_;         // coupled row -> equation
  std::vector<std::size_t> row_end_;  // coupled row -> end of its entries
  std::vector<Term> terms_;           // of the slopes
  Places places_{};
  std::vector<Numbers, LineAllocator<Numbers>> numbers_;  // packs
  LaneArray slopes_;                                      // packs x entries x W: H
  LaneArray used_;                                        // packs x W
  LaneArray at_rest_;                                     // packs x DistanceEquations::at_rest()
};

// A vector of rows at a time: within it each load is combined with the loads 1, 2, 4, ... rows before it, so that gains
// are multiplied over one vector only. The last load is carried to the next vector.
void complete_chain(const double* gains, double before, std::int32_t count, double* loads) {
  constexpr hn::CappedTag<double, 8> d;
  constexpr std::int32_t lanes = static_cast<std::int32_t>(hn::MaxLanes(d));
  std::int32_t i = 0;
  if constexpr (lanes > 2) {
    constexpr int kPasses = lanes > 4 ? 3 : 2;
    alignas(kLineBytes) std::int64_t rows[lanes];
    const auto lane = [&](auto row) {
      for (std::int64_t l = 0; l < lanes; ++l) rows[l] = row(l);
      return hn::SetTableIndices(d, rows);
    };
    decltype(lane([](std::int64_t l) { return l; })) earlier[kPasses];
    for (int k = 0; k < kPasses; ++k) {
      earlier[k] = lane([&](std::int64_t l) { return std::max<std::int64_t>(l - (1 << k), 0); });
    }
    const auto last = lane([](std::int64_t) { return lanes - 1; });
    auto carried = hn::Set(d, before);
    for (; i + lanes <= count; i += lanes) {
      auto gain = hn::LoadU(d, gains + i), load = hn::LoadU(d, loads + i);
      for (int k = 0; k < kPasses; ++k) {
        const auto first = hn::FirstN(d, static_cast<std::size_t>(1) << k);
        load = hn::MulAdd(gain, hn::IfThenZeroElse(first, hn::TableLookupLanes(load, earlier[k])), load);
        gain = hn::Mul(gain, hn::IfThenElse(first, hn::Set(d, 1.0), hn::TableLookupLanes(gain, earlier[k])));
      }
      load = hn::MulAdd(gain, carried, load);
      hn::StoreU(load, d, loads + i);
      carried = hn::TableLookupLanes(load, last);
    }
    before = hn::GetLane(carried);
  }
  Lanes<1> load = Lanes<1>::set(before);
  for (; i < count; ++i) {
    Lanes<1> next = Lanes<1>::load(loads + i);
    next.add_product(Lanes<1>::load(gains + i), load);
    next.store(loads + i);
    load = next;
  }
}
ChainOfLoads chain() { return complete_chain; }

template <int W, int N>
TogetherStep* of_size(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                      const Separable& separable, std::span<const std::uint8_t> computed) {
  if (measures_distances(separable, program)) {
    return new TogetherStepOf<W, N, DistanceEquations<Lanes<W>, N>>(group_class, program, blocks, separable, computed);
  }
  return new TogetherStepOf<W, N, SeparableEquations<Lanes<W>, N>>(group_class, program, blocks, separable, computed);
}

template <int W>
TogetherStep* of_lanes(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                       const Separable& separable, std::span<const std::uint8_t> computed) {
  return program.n == 2 ? of_size<W, 2>(group_class, program, blocks, separable, computed)
                        : of_size<W, 3>(group_class, program, blocks, separable, computed);
}

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128
// why_not_together() refuses the strategy on processors without SIMD.
TogetherStep* make(const GroupClass&, const Program&, const BlockConditions&, const Separable&,
                   std::span<const std::uint8_t>, int) {
  return nullptr;
}
#else
TogetherStep* make(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                   const Separable& separable, std::span<const std::uint8_t> computed, int lanes) {
  switch (lanes) {
    case 4:
      return of_lanes<4>(group_class, program, blocks, separable, computed);
    case 8:
      return of_lanes<8>(group_class, program, blocks, separable, computed);
    default:
      return of_lanes<16>(group_class, program, blocks, separable, computed);
  }
}
#endif

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);
HWY_EXPORT(chain);

ChainOfLoads chain_of_loads() { return HWY_DYNAMIC_DISPATCH(chain)(); }

std::unique_ptr<TogetherStep> make_together_step(const GroupClass& group_class, const Program& program,
                                                 const BlockConditions& blocks, std::span<const std::uint8_t> computed,
                                                 int lanes) {
  const auto separable = separate(program, group_class.input_moves);
  return std::unique_ptr<TogetherStep>(
      HWY_DYNAMIC_DISPATCH(make)(group_class, program, blocks, *separable, computed, lanes));
}

}  // namespace assur
#endif

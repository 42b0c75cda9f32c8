// Window minima over the margin images, for the free-space tests.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/free_space/scan_tables.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <limits>

#include "mapping/integrator/dynamic_loop.h"
#include "mapping/integrator/free_space/fill_kernels.h"
#include "mapping/integrator/free_space/free_space_tables.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// out[i] = least of a[i], a[i + step], b[i], b[i + step]; out may be a. Reads and writes whole vectors, so
/// the last `count` % Lanes are done one by one.
template <typename T>
HWY_INLINE void LeastOfFour(const T* a, const T* b, size_t step, size_t count, T* out) {
  const hn::ScalableTag<T> d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto m = hn::Min(hn::LoadU(d, a + i), hn::LoadU(d, a + i + step));
    const auto n = hn::Min(hn::LoadU(d, b + i), hn::LoadU(d, b + i + step));
    hn::StoreU(hn::Min(m, n), d, out + i);
  }
  for (; i < count; ++i) out[i] = std::min(std::min(a[i], a[i + step]), std::min(b[i], b[i + step]));
}
void LeastFloat(const float* a, const float* b, size_t step, size_t count, float* out) {
  LeastOfFour(a, b, step, count, out);
}
void LeastPair(const uint16_t* a, const uint16_t* b, size_t step, size_t count, uint16_t* out) {
  LeastOfFour(a, b, step, count, out);
}

/// Packs bounds: least `own` rounded down, greatest bound rounded up and complemented.
void PackBounds(const float* own, const float* bound, float per_unit, size_t count, uint32_t* out) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t lanes = hn::Lanes(d);
  const auto scale = hn::Set(d, per_unit);
  const auto top = hn::Set(di, 65535);
  for (size_t i = 0; i < count; i += lanes) {
    const auto low = hn::ConvertTo(di, hn::Mul(hn::LoadU(d, own + i), scale));
    const auto high = hn::Add(hn::ConvertTo(di, hn::Mul(hn::LoadU(d, bound + i), scale)), hn::Set(di, 2));
    const auto packed = hn::Or(hn::Min(low, top), hn::ShiftLeft<16>(hn::Sub(top, hn::Min(high, top))));
    hn::StoreU(packed, di, reinterpret_cast<int32_t*>(out) + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {

HWY_EXPORT(LeastFloat);
HWY_EXPORT(LeastPair);
HWY_EXPORT(PackBounds);

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kGrazingReach = 4.0f;  ///< the reach behind a surface grows so far along grazing beams
constexpr size_t kSlack = 64;          ///< whole vectors may be read past the last row

/// Repeats the first columns of a row of `columns` behind it, up to `pitch`.
template <typename T>
void RepeatColumns(T* row, size_t columns, size_t pitch) {
  for (size_t i = columns; i < pitch; ++i) row[i] = row[i - columns];
}

/// 2 x 2 minima in place, from single cells stored below a row of nothing.
void SurroundTable(const RangeImage& image, size_t pitch, std::vector<float>* table) {
  const auto columns = static_cast<size_t>(image.columns);
  const auto rows = static_cast<size_t>(image.rows);
  std::fill_n(table->begin(), pitch, kNothing);
  for (size_t row = 1; row <= rows; ++row) RepeatColumns(table->data() + row * pitch, columns, pitch);
  for (size_t row = 0; row <= rows; ++row) {
    float* here = table->data() + row * pitch;
    const float* next = row < rows ? here + pitch : here;
    for (const GridColumns::Run& run : image.runs) {
      float* from = here + run.first;
      HWY_DYNAMIC_DISPATCH(LeastFloat)(from, next + run.first, 1, run.last - run.first, from);
    }
    RepeatColumns(here, columns, pitch);
  }
}

/// Level k from level k - 1: windows twice as wide, twice as tall, or both.
void WindowLevel(const std::vector<float>& finer, size_t k, FreeSpaceTables* tables) {
  const RangeImage& image = *tables->image;
  const auto pitch = static_cast<size_t>(tables->pitch), columns = static_cast<size_t>(image.columns);
  const int tall = tables->window_rows[k], tall_finer = tables->window_rows[k - 1];
  const size_t step = tables->window_columns[k] > tables->window_columns[k - 1]
                          ? static_cast<size_t>(tables->window_columns[k - 1])
                          : 0;
  std::vector<float>& table = tables->window[k];
  const int first = -(tall - 1), first_finer = -(tall_finer - 1);
  static const std::vector<float> nothing(32768, kNothing);
  const auto finer_row = [&](int row) {
    return row < first_finer || row >= image.rows
               ? nothing.data()
               : finer.data() + static_cast<size_t>(row - first_finer) * pitch;
  };
  for (int row = first; row < image.rows; ++row) {
    float* out = table.data() + static_cast<size_t>(row - first) * pitch;
    const int other = tall > tall_finer ? row + tall_finer : row;
    for (const GridColumns::Run& run : image.runs) {
      HWY_DYNAMIC_DISPATCH(LeastFloat)
      (finer_row(row) + run.first, finer_row(other) + run.first, step, run.last - run.first, out + run.first);
    }
    RepeatColumns(out, columns, pitch);
  }
}

void WindowTables(FreeSpaceTables* tables) {
  for (size_t k = 2; k < FreeSpaceTables::kLevels; ++k) {
    WindowLevel(k == 2 ? tables->surround[0] : tables->window[k - 1], k, tables);
  }
}

void BoxTables(const ImageOptions& options, const SurfaceImage& surface, FreeSpaceTables* tables) {
  const RangeImage& image = *surface.image;
  const auto columns = static_cast<size_t>(image.columns), rows = static_cast<size_t>(image.rows);
  std::vector<float> row_bound(columns + kSlack);
  tables->box_unit_m = (options.max_range_m + kGrazingReach * options.reach_behind_m + 1.0f) / 65000.0f;
  const size_t pitch = tables->box_pitch, stride = tables->box_stride;
  for (size_t row = 0; row < rows; ++row) {
    const float* own = tables->own[0].data() + row * static_cast<size_t>(tables->pitch);
    const float* bound = own;
    if (options.reach_behind_m > 0.0f) {
      for (size_t i = 0; i < columns; ++i) {
        const size_t cell = row * columns + i;
        const float reach = options.reach_behind_m * std::min(surface.inverse_cos[cell], kGrazingReach);
        row_bound[i] = image.range[cell] > 0.0f ? std::max(own[i], image.range[cell] + reach) : own[i];
      }
      bound = row_bound.data();
    }
    uint32_t* out = tables->box.data() + row * pitch;
    for (const GridColumns::Run& run : image.runs) {
      HWY_DYNAMIC_DISPATCH(PackBounds)
      (own + run.first, bound + run.first, 1.0f / tables->box_unit_m, run.last - run.first, out + run.first);
    }
    RepeatColumns(out, columns, pitch);
  }
  const auto widen = [&](size_t from, size_t to, size_t across, size_t down) {
    for (size_t row = 0; row < rows; ++row) {
      const uint32_t* a = tables->box.data() + from * stride + row * pitch;
      const uint32_t* b = tables->box.data() + from * stride + std::min(row + down, rows - 1) * pitch;
      uint32_t* out = tables->box.data() + to * stride + row * pitch;
      for (const GridColumns::Run& run : image.runs) {
        HWY_DYNAMIC_DISPATCH(LeastPair)
        (reinterpret_cast<const uint16_t*>(a + run.first), reinterpret_cast<const uint16_t*>(b + run.first),
         2 * across, 2 * (run.last - run.first), reinterpret_cast<uint16_t*>(out + run.first));
      }
      RepeatColumns(out, columns, pitch);
    }
  };
  for (int s = 0; s < tables->box_shift; ++s) widen(0, 0, size_t{1} << s, 0);
  for (size_t k = 1; k < FreeSpaceTables::kBoxLevels; ++k) {
    widen(k - 1, k, size_t{1} << (k - 1 + static_cast<size_t>(tables->box_shift)), size_t{1} << (k - 1));
  }
}

}  // namespace

FreeSpaceTables::FreeSpaceTables(const RangeImage& of) : Margins(of) {
  const BeamGrid& grid = *of.grid;
  const auto width = static_cast<size_t>(pitch), columns = static_cast<size_t>(grid.columns);
  const auto rows = static_cast<size_t>(grid.rows);
  constexpr size_t kRowsBelow = CubeSlopes::kRows[CubeSlopes::kWindows - 1];  // windows may reach out
  for (std::vector<float>& table : own) table.resize((rows + kRowsBelow) * width + kSlack);
  for (std::vector<float>& table : surround) {
    table.resize((rows + 1 + kRowsBelow) * width + kSlack);
  }

  const double ratio = grid.mean_row_pitch_rad / grid.column_pitch_rad;
  const int bias = static_cast<int>(std::lround(std::log2(ratio)));
  for (int k = 0; k < kLevels; ++k) {
    const auto level = static_cast<size_t>(k);
    const int tall = 1 << (k == 0 ? 0 : std::max(1, k - std::max(bias, 0)));
    window_rows[level] = tall;
    window_columns[level] = 1 << (k == 0 ? 0 : std::max(1, k - std::max(-bias, 0)));
    if (k >= 2) window[level].resize((rows + static_cast<size_t>(tall) - 1 + kRowsBelow) * width + kSlack);
  }

  box_shift = std::clamp(static_cast<int>(std::ceil(std::log2(ratio))), 0, 3);
  // Repeated columns: the widest step from level to level, and a whole vector.
  box_pitch = columns + (size_t{1} << (kBoxLevels - 2 + box_shift)) + 32;
  box_stride = rows * box_pitch + kSlack;
  box.resize(kBoxLevels * box_stride);
}

void BuildTables(const ImageOptions& options, const SurfaceImage& surface, FreeSpaceTables* tables) {
  const RangeImage& image = *surface.image;
  const auto pitch = static_cast<size_t>(tables->pitch);
  for (size_t k = 0; (1 << k) <= options.max_scale; ++k) {
    for (size_t row = 0; row < static_cast<size_t>(image.rows); ++row) {
      RepeatColumns(tables->own[k].data() + row * static_cast<size_t>(tables->pitch),
                    static_cast<size_t>(image.columns), static_cast<size_t>(tables->pitch));
    }
  }
  ForEachDynamic(options.threads, 2, [&](size_t i, int) {
    if (i == 0) return BoxTables(options, surface, tables);
    for (size_t k = 0; (1 << k) <= options.max_scale; ++k) SurroundTable(image, pitch, &tables->surround[k]);
    WindowTables(tables);
  });
}

}  // namespace atlas::mapping
#endif

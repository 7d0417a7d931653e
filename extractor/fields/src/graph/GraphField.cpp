#include "graph/Program.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace isofront::fields::graph {

namespace {

class GraphField final : public Field {
public:
    GraphField(const Node& node, const GraphSettings& settings, std::span<const Material> materials)
        : _program(compiled(node, settings))
    {
        std::uint32_t number = 0;
        for (const Material& material : materials) {
            LaidOut laid{++number << 24U | (material.colour & 0xffffffU), std::nullopt};
            if (material.where)
                laid.where = compiled(*material.where, settings);
            _materials.push_back(std::move(laid));
        }
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "as many values as points");
        sampleProgram(_program, batch, values);
    }
    void sampleGrid(const SampleGrid& grid, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == grid.size(), "as many values as points");
        // What a small grid shares doesn't pay for finding it.
        constexpr std::int64_t kShortest = 8;
        constexpr std::size_t kFewest = 512;
        if (grid.count.x < kShortest || grid.size() < kFewest)
            Field::sampleGrid(grid, values);
        else
            gridProgram(_program, grid, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        gradientProgram(_program, batch, gradients);
    }
    void sampleWithGradient(
        const SampleBatch& batch, std::span<float> values, GradientSpans gradients) const override
    {
        sampleAndGradientProgram(_program, batch, values, gradients);
    }
    bool hasAttributes() const override { return !_materials.empty(); }
    void attributes(const SampleBatch& batch, std::span<std::uint32_t> words) const override
    {
        ISOFRONT_ASSERT(words.size() == batch.size(), "as many words as points");
        std::ranges::fill(words, 0U);
        std::vector<float> where(batch.size());
        for (const LaidOut& material : _materials) {
            if (material.where)
                sampleProgram(*material.where, batch, where);
            for (std::size_t i = 0; i < words.size(); ++i)
                if (words[i] == 0 && (!material.where || where[i] >= 0))
                    words[i] = material.word;
        }
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return boundProgram(_program, box, radius);
    }
    double differenceStep(double radius) const override
    {
        // A tenth of the shortest wave; without noise, what floats can tell apart at a kilometre.
        const double finest = _program.shortest > 0 ? 0.05 * _program.shortest : 1e-3;
        double step = std::max(0.5 * radius, finest);
        for (const std::shared_ptr<const Field>& source : _program.sources)
            step = std::min(step, source->differenceStep(radius));
        return step;
    }

private:
    struct LaidOut {
        std::uint32_t word;
        std::optional<Program> where;
    };

    Program _program;
    std::vector<LaidOut> _materials;
};

} // namespace

std::shared_ptr<const Field>
graphField(const Node& node, const GraphSettings& settings, std::span<const Material> materials)
{
    ISOFRONT_ASSERT(materials.size() <= kMostMaterials, "too many materials to number");
    return std::make_shared<GraphField>(node, settings, materials);
}

} // namespace isofront::fields::graph

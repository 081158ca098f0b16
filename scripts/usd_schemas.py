"""Properties of all schemas of Pixar's own library, with their fallbacks.

    pip install usd-core
    cargo xtask measure schemas

The unit tests of the loader's `properties` compare with the list: each property is read, noted or
has no effect. A line is `schema property fallback`, separated by tabs, or a schema alone; fallbacks
are as texts of USD have them. For schemas that may be applied more than once the instance is `x`.
Properties of abstract schemas are among those of the schemas that are made of them.
"""

from pxr import Sdf, Tf, Usd


def text(value):
    """Returns a value as text of `.usda`."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    prim = Sdf.PrimSpec(layer, "P", Sdf.SpecifierDef)
    attribute = Sdf.AttributeSpec(prim, "a", Sdf.GetValueTypeNameForValue(value))
    attribute.default = value
    line = next(line for line in layer.ExportToString().splitlines() if " a = " in line)
    return line.split(" a = ", 1)[1]


def lines():
    registry = Usd.SchemaRegistry()
    for schema in Tf.Type.Find(Usd.SchemaBase).GetAllDerivedTypes():
        name = registry.GetSchemaTypeName(schema)
        definition = registry.FindConcretePrimDefinition(name) or registry.FindAppliedAPIPrimDefinition(name)
        if not definition:
            continue
        yield name
        for found in definition.GetPropertyNames():
            spec = definition.GetSchemaPropertySpec(found)
            fallback = None if isinstance(spec, Sdf.RelationshipSpec) else spec.default
            fields = [name, found.replace("__INSTANCE_NAME__", "x")]
            yield "\t".join(fields if fallback is None else [*fields, text(fallback)])


if __name__ == "__main__":
    print("\n".join(sorted(set(lines()))))

# docker build -t tashika . && docker run --rm -v "$PWD":/scenes tashika render kitchen.glb -o kitchen.exr
FROM rust:1-slim-trixie AS build
WORKDIR /tashika
COPY . .
RUN cargo build --locked --profile dist --package tashika-cli

FROM debian:trixie-slim
COPY --from=build /tashika/target/dist/tashika /usr/local/bin/
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/tashika/
WORKDIR /scenes
ENTRYPOINT ["tashika"]

# A Linux in which a student's work builds, is checked, drawn and debugged, on any machine with Docker or Podman, and
# for VS Code (.devcontainer); docs/machines.md says how. What is installed are bootstrap's own lists:
# --build-arg LIST= takes the whole kit's.
FROM debian:bookworm-slim
ARG LIST=--student
COPY bootstrap /root/
RUN /root/bootstrap $LIST --only-install && rm -rf /var/lib/apt/lists/* && useradd --create-home --shell /bin/bash student
USER student
WORKDIR /raykit
CMD ["bash"]

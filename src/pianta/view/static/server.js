// Where floors come from: the server of `pianta view`, or the data in a report, which is read-only.

// An answer that is not 200. status: of HTTP; 0 without an answer.
export class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

const NO_ANSWER = "The server of pianta view does not answer. Start it again; what is not saved stays in this tab.";

async function request(path, body) {
  let answer;
  try {
    answer = await fetch(path, body === undefined ? { cache: "no-store" } : {
      method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body),
    });
  } catch {
    throw new Refused(0, NO_ANSWER);
  }
  let content = null;
  try {
    content = await answer.json();
  } catch {
    throw new Refused(answer.status, `The server gave no answer that can be read (${answer.status}).`);
  }
  if (!answer.ok) throw new Refused(answer.status, content.error ?? `The server refused (${answer.status}).`);
  return content;
}

class Server {
  readOnly = false;

  async listMaps() {
    return (await request("api/maps")).maps;
  }

  getMap(number) {
    return request(`api/maps/${number}`);
  }

  getPart(number, part) {
    return request(`api/maps/${number}/parts/${part}`);
  }

  async getVersion(number) {
    return (await request(`api/maps/${number}/version`)).version;
  }

  edit(number, version, corrections, edit) {
    return request(`api/maps/${number}/edit`, { version, corrections, edit });
  }

  apply(number, version, corrections) {
    return request(`api/maps/${number}/apply`, { version, corrections });
  }

  save(number, version, corrections) {
    return request(`api/maps/${number}/save`, { version, corrections });
  }
}

class Report {
  readOnly = true;

  constructor(states) {
    this.states = states;
  }

  async listMaps() {
    return this.states.map((state, map) => {
      if (state.kind) return { map, name: state.name, kind: state.kind, facts: state.facts };
      const areas = state.floor.features.map((feature) => feature.properties.area ?? 0);
      const rooms = state.floor.features.filter((feature) => feature.properties.class === "room").length;
      const type = Object.entries(state.building_type).sort((a, b) => b[1] - a[1])[0]?.[0] ?? null;
      const area = areas.reduce((sum, each) => sum + each, 0);
      return { map, name: state.name, rooms, area, areas: state.areas, type, corrections: state.corrections.length };
    });
  }

  async getMap(number) {
    return { ...this.states[number], writable: false };
  }

  async getPart(number, part) {
    return this.states[number].parts[part];
  }
}

export function openSource() {
  const data = document.getElementById("pianta-data");
  return data ? new Report(JSON.parse(data.textContent).maps) : new Server();
}
